"""Haze: fog and rain attenuate contrast with the distance."""

import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.sky.hills import HILLS
from vpf_sim.types import Camera, Floats, Image

LEAST_LEVELS = 1.0  # smaller changes are left out


class Haze:
    """L = L0 t + A (1 - t) with t = exp(-k depth) (Koschmieder, Beitr. Phys. freien Atm. 12:33, 1924).

    A, the airlight, is the colour of the sky at the horizon; k is the atmosphere's extinction. Rows of the ground take
    one multiplication and one addition in 8 bits.
    """

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light) -> None:
        self._extinction_per_m = atmosphere.extinction_per_m
        self._horizon = light.horizon
        self._strongest = float(np.maximum(light.horizon, 255.0 - light.horizon).max())
        self._row_depths_m = _depth_of_rows(camera)

    def transmission(self, depth_m: Floats) -> Floats:
        """Transmission t at depths, 0 to 1, in the same shape."""
        return np.asarray(np.exp(-self._extinction_per_m * depth_m))

    def ground_rows(self) -> Image:
        """(rows, 4) transmission of 255 and the air's RGB, of the rows of the ground that show haze."""
        transmission = self.transmission(self._row_depths_m)
        share = np.rint(255.0 * transmission[self._is_visible(transmission), None])
        return np.concatenate([share, np.rint((1.0 - share / 255.0) * self._horizon)], axis=1).astype(np.uint8)

    def _is_visible(self, transmission: Floats) -> Floats:
        """Where a transmission changes any colour by a grey level."""
        return np.asarray((1.0 - transmission) * self._strongest >= LEAST_LEVELS)


def _depth_of_rows(camera: Camera) -> Floats:
    """(rows,) m, depth of the ground in each row from its top down, limited by the line of trees."""
    y = (np.arange(ground_top(camera), camera.height_px) - camera.cy_px) / camera.fy_px
    depth = camera.height_m / (y * np.cos(camera.pitch_rad) + np.sin(camera.pitch_rad))
    return np.asarray(np.minimum(depth, HILLS[-1][0]))
