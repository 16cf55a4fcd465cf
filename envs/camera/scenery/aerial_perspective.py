"""Colours of faces through the air, ready to be laid over the picture."""

import numpy as np

from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.types import Floats


def contrasts(colours: Floats, light: Light) -> Floats:
    """(n, 4) what sets (n, 3) colours off against the horizon, and a column of zeros."""
    return np.column_stack([colours - light.horizon, np.zeros(len(colours))])


class AerialPerspective:
    """The air between the camera and all faces.

    A face of colour c and opacity o, of whose contrast with the horizon h the air leaves t (Koschmieder), shows
    o (h + t (c - h)) and lets 255 (1 - o) of 255 through.
    """

    def __init__(self, light: Light, haze: Haze) -> None:
        self._haze = haze
        self._horizon = np.array([*light.horizon, -255.0])

    def colours(self, contrast: Floats, depth_m: Floats, opacity: Floats) -> Floats:
        """(n, 4) RGB times opacity, and what is seen through, of 255; for (n, 4) contrasts. Depths and opacities are
        (n,) or (1,)."""
        result = contrast * (self._haze.transmission(depth_m) * opacity)[:, None]
        result += opacity[:, None] * self._horizon
        result[:, 3] += 255.0
        return result
