"""What fog and rain put before things, the more the farther they are."""

import cv2
import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.sky.hills import HILLS
from vpf_sim.types import Camera, Floats, Image

LEAST_LEVELS = 1.0  # what changes by less is left as it is


class Haze:
    """L = L0 t + A (1 - t) with t = exp(-k depth) (Koschmieder, Beitr. Phys. freien Atm. 12:33, 1924).

    A is the colour of the sky at the horizon, k the atmosphere's extinction. Rows of the ground are veiled in 8 bits by
    one multiplication and one addition.
    """

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light) -> None:
        self._extinction_per_m = atmosphere.extinction_per_m
        self._horizon = light.horizon
        self._strongest = float(np.maximum(light.horizon, 255.0 - light.horizon).max())
        top, left = ground_top(camera), self.transmission(_depth_of_rows(camera))
        veiled = int(np.count_nonzero(self._shows(left)))
        self._rows = slice(top, top + veiled)
        shape = (veiled, camera.width_px, 3)
        self._left = np.empty(shape, np.uint8)
        self._added = np.empty(shape, np.uint8)
        if veiled:
            share = np.rint(255.0 * left[:veiled, None, None])
            self._left[:] = share
            self._added[:] = np.rint((1.0 - share / 255.0) * self._horizon)

    def transmission(self, depth_m: Floats) -> Floats:
        """What is left of the contrast with the horizon of things at depths, 0 to 1, in the same shape."""
        return np.asarray(np.exp(-self._extinction_per_m * depth_m))

    def ground(self, frame: Image) -> None:
        """Veil the rows of the ground, in place."""
        if len(self._left):
            part = frame[self._rows]
            cv2.multiply(part, self._left, part, scale=1 / 255)
            cv2.add(part, self._added, part)

    def colours(self, colours: Floats, depth_m: Floats) -> Floats:
        """(n, 3) colours as they are seen from (n,) depths."""
        left = self.transmission(depth_m)[:, None]
        return np.asarray(self._horizon + (colours - self._horizon) * left)

    def _shows(self, left: Floats) -> Floats:
        """Where a transmission changes any colour by a level."""
        return np.asarray((1.0 - left) * self._strongest >= LEAST_LEVELS)


def _depth_of_rows(camera: Camera) -> Floats:
    """(rows,) m along the optical axis of the ground that each row sees, from the top of the ground down; no farther
    than the line of trees that ends it."""
    y = (np.arange(ground_top(camera), camera.height_px) - camera.cy_px) / camera.fy_px
    depth = camera.height_m / (y * np.cos(camera.pitch_rad) + np.sin(camera.pitch_rad))
    return np.asarray(np.minimum(depth, HILLS[-1][0]))
