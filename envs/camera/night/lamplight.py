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

    def street_lx(self, points_m: Floats, lamps_m: Floats | None = None) -> Floats:
        """(n,) lx of street lamps at points (n, 3) on level planes: I h / d^3 for a lamp h above them.

        `lamps_m` are those that may light the points, (k, 3); None: found here.
        """
        total = np.zeros(len(points_m))
        x, y, z = np.ascontiguousarray(points_m.T, np.float32)
        for lamp_x, lamp_y, lamp_z in (self._near(points_m) if lamps_m is None else lamps_m).tolist():
            height = np.maximum(np.float32(lamp_z) - z, np.float32(0.1))
            squared = (x - np.float32(lamp_x)) ** 2 + (y - np.float32(lamp_y)) ** 2 + height**2
            distance = np.sqrt(squared)
            fading = np.clip(4.0 - distance / height, 0.0, 1.0)  # dark from 70 to 76 deg on
            total += np.float32(STREET_CD) * fading * height / (squared * distance)
        return total

    def lamps_ahead(self, view: View, range_m: float) -> Floats:
        """(k, 3) the street lamps up to `range_m` ahead, and those behind that light what is ahead."""
        apart = self.street_lamps_m[:, :2] - view.centre[:2]
        ahead = apart @ view.axes[2, :2]
        near = np.abs(apart).max(axis=1, initial=0.0) < range_m
        shown: Bools = near & (ahead > -STREET_RANGE_M)
        return np.asarray(self.street_lamps_m[shown])

    def on_faces(self, view: View, faces_m: Floats, normals: Floats, retro: Bools) -> Floats:
        """(n, 3) RGB factors of faces (n, V, 3) in world axes with `normals` (n, 3), by the light at their middles."""
        middles_m = 0.5 * (faces_m.min(axis=1) + faces_m.max(axis=1))
        c, s = cos(view.yaw_rad), sin(view.yaw_rad)
        ahead = LAMP_AHEAD_M - view.camera.forward_m
        lamps = np.array([view.centre[0] + ahead * c, view.centre[1] + ahead * s, LAMP_HEIGHT_M])
        rays = lamps - middles_m
        facing = np.maximum((normals * rays).sum(axis=1), 0.0) / np.linalg.norm(rays, axis=1)
        lux = self.beam_lx(view, middles_m) * np.where(retro, RETRO, facing)
        lux += self.street_lx(middles_m) * (0.5 + 0.5 * normals[:, 2])
        return self.factor(lux)

    def on_leaves(self, view: View, points_m: Floats) -> Floats:
        """(n, 3) RGB factors of leaves at world points (n, 3)."""
        return self.factor(LEAVES * (self.beam_lx(view, points_m) + self.street_lx(points_m)))

    def factor(self, lux: Floats) -> Floats:
        """(..., 3) RGB factors of surfaces under the sky and lamps of (...,) lx."""
        return np.asarray((self._sky + lux[..., None] / self.light.white_lx) ** (1.0 / GAMMA))

    def _near(self, points_m: Floats) -> Floats:
        """(k, 3) the street lamps that may light any of the points (n, 3)."""
        lamps = self.street_lamps_m
        if not len(lamps) or not len(points_m):
            return lamps[:0]
        low, high = points_m[:, :2].min(axis=0) - STREET_RANGE_M, points_m[:, :2].max(axis=0) + STREET_RANGE_M
        near: Bools = ((lamps[:, :2] > low) & (lamps[:, :2] < high)).all(axis=1)
        return np.asarray(lamps[near])
