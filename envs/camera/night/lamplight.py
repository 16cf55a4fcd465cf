"""Illuminance by the car's own headlamps and by street lamps."""

from math import cos, sin

import numpy as np

from vpf_sim.envs.camera.light import GAMMA, Light
from vpf_sim.envs.camera.night.low_beam import intensity_cd
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Bools, Floats

LAMP_AHEAD_M, LAMP_ASIDE_M, LAMP_HEIGHT_M = 2.2, 0.6, 0.65  # of the two headlamps, from the car's middle
NEAREST_M = 0.3  # ahead of the lamps; nothing nearer is lit
STREET_CD = 1200.0  # of a street lamp, up to 60 deg from straight down
STREET_RANGE_M = 36.0  # within which a street lamp lights anything
TYPICAL_LX = 5.0  # of lamps on the road
LEAVES = 0.35  # share of a facing surface's light that leaves and rough ground return
RETRO = 25.0  # luminance of a retroreflective sheet over that of a matt white one (EN 12899 class RA1, in a low beam)


class Lamplight:
    """Light of lamps in one road: E = sum of I / d^2 over lamps of intensity I at distance d, in lx.

    The car's low beams are on in the dark (`Light.has_lamps`). A surface's factor adds up the light of the sky and of
    the lamps before the gamma: (sky^2.2 + E / white)^(1 / 2.2), with the exposure's `white_lx`.
    """

    def __init__(self, light: Light, street_lamps_m: Floats) -> None:
        """`street_lamps_m` is (n, 3), the world positions of the street lamps."""
        self.light = light
        self.street_lamps_m = street_lamps_m
        self._sky = light.ground**GAMMA
        self.share = TYPICAL_LX / (TYPICAL_LX + float(self._sky.mean()) * light.white_lx)  # of the light on the road

    def beam_lx(self, view: View, points_m: Floats) -> Floats:
        """(...,) lx of both headlamps at world points (..., 3), on planes that face them."""
        c, s = cos(view.yaw_rad), sin(view.yaw_rad)
        x, y, up = points_m[..., 0] - view.centre[0], points_m[..., 1] - view.centre[1], points_m[..., 2]
        ahead = c * x + s * y - (LAMP_AHEAD_M - view.camera.forward_m)
        right, up = c * y - s * x, up - LAMP_HEIGHT_M
        lit = ahead > NEAREST_M
        ahead = np.where(lit, ahead, NEAREST_M)
        total = np.zeros(np.shape(ahead))
        for aside in (right - LAMP_ASIDE_M, right + LAMP_ASIDE_M):
            total += intensity_cd(aside / ahead, up / ahead) / (ahead**2 + aside**2 + up**2)
        return np.asarray(np.where(lit, total, 0.0))

    def lamps_ahead(self, view: View, range_m: float) -> Floats:
        """(k, 3) the street lamps up to `range_m` ahead, and those behind that light what is ahead."""
        apart = self.street_lamps_m[:, :2] - view.centre[:2]
        ahead = apart @ view.axes[2, :2]
        near = np.abs(apart).max(axis=1, initial=0.0) < range_m
        shown: Bools = near & (ahead > -STREET_RANGE_M)
        return np.asarray(self.street_lamps_m[shown])

    def factor(self, lux: Floats) -> Floats:
        """(..., 3) RGB factors of surfaces under the sky and lamps of (...,) lx."""
        return np.asarray((self._sky + lux[..., None] / self.light.white_lx) ** (1.0 / GAMMA))
