"""The noise of the sensor."""

import cv2
import numpy as np

from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Image

MARGIN_PX = 256  # how far the bank is larger than the picture


class Noise:
    """Temporal noise, nearly of one size over all tones after a gamma of 2.2 in 8 bits (WEATHER 5).

    A bank is drawn once; each frame adds it from another corner.
    """

    def __init__(self, camera: Camera, sd: float, seed: int) -> None:
        self._rng = stream(seed, "sensor noise")
        self._size = (camera.height_px, camera.width_px)
        shape = (camera.height_px + MARGIN_PX, 3 * (camera.width_px + MARGIN_PX))
        bank = np.rint(sd * stream(0, "noise bank").standard_normal(shape, dtype=np.float32)) if sd > 0.0 else None
        self._layers = None if bank is None else tuple(np.clip(s * bank, 0, 255).astype(np.uint8) for s in (1, -1))

    def add(self, frame: Image) -> None:
        """Add the next frame's noise."""
        if self._layers is None:
            return
        y, x = (int(i) for i in self._rng.integers(0, MARGIN_PX, 2))
        height, width = self._size
        brighter, darker = (layer[y : y + height, 3 * x : 3 * (x + width)] for layer in self._layers)
        flat = frame.reshape(height, 3 * width)
        cv2.add(flat, brighter, flat)
        cv2.subtract(flat, darker, flat)
