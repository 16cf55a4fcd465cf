"""What fog and rain put before things, the more the farther they are."""

import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.types import Camera, Floats, Image


class Veil:
    """L = L0 t + A (1 - t) with t = exp(-k depth) (Koschmieder 1924); A is the colour of the horizon."""

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light) -> None:
        self._extinction_per_m = atmosphere.extinction_per_m
        self._horizon = light.horizon

    def ground(self, frame: Image) -> None:
        """Veil the rows of the ground, in place."""

    def colours(self, colours: Floats, depth_m: Floats) -> Floats:
        """(n, 3) colours as they are seen from (n,) depths."""
        left = np.exp(-self._extinction_per_m * depth_m)[:, None]
        return np.asarray(self._horizon + (colours - self._horizon) * left)
