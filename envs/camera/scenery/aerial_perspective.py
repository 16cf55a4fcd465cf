"""Aerial perspective: colours of faces through the haze."""

import numpy as np

from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.types import Floats


def contrasts(colours: Floats, light: Light) -> Floats:
    """(n, 4) contrasts of (n, 3) colours with the horizon, and a column of zeros."""
    return np.column_stack([colours - light.horizon, np.zeros(len(colours))])


class AerialPerspective:
    """Applies haze and opacity to the colours of faces.

    A face of colour c and opacity o at transmission t (Koschmieder) has the premultiplied colour o (h + t (c - h)),
    with the horizon's colour h, and the transparency 255 (1 - o).
    """

    def __init__(self, light: Light, haze: Haze) -> None:
        self._haze = haze
        self._horizon = np.array([*light.horizon, -255.0])

    def colours(self, contrast: Floats, depth_m: Floats, opacity: Floats) -> Floats:
        """(n, 4) premultiplied RGB and transparency, of 255, for (n, 4) contrasts.

        Depths and opacities are (n,) or (1,).
        """
        result = contrast * (self._haze.transmission(depth_m) * opacity)[:, None]
        result += opacity[:, None] * self._horizon
        result[:, 3] += 255.0
        return result
