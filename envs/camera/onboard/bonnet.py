"""The car's own bonnet at the lower edge of the picture, which mirrors the scene."""

import cv2
import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.types import Bools, Camera, Image

SHARE = 0.13  # of the picture's height, in its middle
CURVE = 0.22  # how much of that it loses towards the sides
PAINT = np.array([38.0, 44.0, 58.0])
MIRRORED = 0.42  # share of the scene in the paint
BLUR = 9  # px, of the reflection


class Bonnet:
    """A curved dark shape; it mirrors the rows above its edge, blurred and upside down."""

    def __init__(self, camera: Camera, light: Light) -> None:
        height, width = camera.height_px, camera.width_px
        across = (np.arange(width) - camera.cx_px) / (0.5 * width)
        edge = height * (1.0 - SHARE * (1.0 - CURVE * across**2))
        self._top = int(edge.min())
        rows = np.arange(self._top, height)[:, None]
        cover = np.rint(255.0 * np.clip(rows - edge + 0.5, 0.0, 1.0)).astype(np.uint8)
        self._cover = cv2.cvtColor(cover, cv2.COLOR_GRAY2RGB)
        self._uncovered = cv2.bitwise_not(self._cover)
        lit = np.clip(PAINT * light.ground, 0.0, 255.0)
        self._paint: Image = np.broadcast_to(lit, self._cover.shape).astype(np.uint8)

    def draw(self, frame: Image) -> None:
        """Draw the bonnet over the frame, in place."""
        part = frame[self._top :]
        above = cv2.blur(cv2.flip(frame[self._top - len(part) : self._top], 0), (BLUR, BLUR))
        shown = cv2.addWeighted(self._paint, 1.0, above, MIRRORED, 0.0)
        cv2.multiply(shown, self._cover, shown, scale=1 / 255)
        cv2.multiply(part, self._uncovered, part, scale=1 / 255)
        cv2.add(part, shown, part)

    def hides(self) -> Bools:
        """(rows, W) where it covers the scene, from the bottom up to its edge."""
        return np.asarray(self._cover)[..., 0] > 127
