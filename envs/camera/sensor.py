"""The sensor: what it adds to the light that falls on it."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.seeding import stream
from vpf_sim.types import Image

MARGIN_PX = 96  # how far the bank is larger than the picture


class Sensor:
    """Temporal noise, nearly of one size over all tones after a gamma of 2.2 in 8 bits.

    A bank is drawn once; each frame adds it from another corner.
    """

    def __init__(self, rig: Rig, weather: Weather, seed: int) -> None:
        self._rng = stream(seed, "sensor noise")
        self._size = (rig.camera.height_px, rig.camera.width_px)
        self._layers = _bank(*self._size, rig.noise_sd) if rig.noise_sd > 0.0 else None

    def expose(self, frame: Image) -> None:
        """Add the next frame's noise, in place."""
        if self._layers is None:
            return
        y, x = (int(i) for i in self._rng.integers(0, MARGIN_PX, 2))
        height, width = self._size
        brighter, darker = (layer[y : y + height, 3 * x : 3 * (x + width)] for layer in self._layers)
        flat = frame.reshape(height, 3 * width)
        cv2.add(flat, brighter, flat)
        cv2.subtract(flat, darker, flat)


@lru_cache(maxsize=2)
def _bank(height: int, width: int, sd: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """What is added and what is subtracted, three channels side by side; drawn once, for it costs 40 ms."""
    shape = (height + MARGIN_PX, 3 * (width + MARGIN_PX))
    levels = np.rint(np.float32(sd) * stream(0, "noise bank").standard_normal(shape, dtype=np.float32))
    return np.clip(levels, 0, 255).astype(np.uint8), np.clip(-levels, 0, 255).astype(np.uint8)
