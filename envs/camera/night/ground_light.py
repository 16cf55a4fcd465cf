"""The light of lamps on the road, for each pixel below the horizon."""

from math import cos, sin
from typing import Any

import cv2
import numpy as np

from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.light import GAMMA
from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.view import View
from vpf_sim.geometry import road_row_px
from vpf_sim.types import Camera, Floats, Image

COLUMN_PX = 8  # the light is smooth across: worked out for every eighth column
FARTHEST_M = 260.0
LARGEST = 2.0  # factor that 255 stands for
STREET_AHEAD_M = 130.0  # street lamps beyond light less than a few rows
# Luminance of dry asphalt towards the driver: 15 mcd/m2 for each lx of his headlamps at 30 m (EN 1436, class RW1 of
# paint has 150), 70 mcd/m2 for each lx from above (CIE 144, road class R3).
ASPHALT = 0.015 / 0.07
PAINT = 0.15 / 0.25  # the same for dry white paint
BRIGHTEST = (PAINT / ASPHALT) ** (1.0 / GAMMA)  # gain of paint over asphalt in the beam, compared with the day


class GroundLight:
    """Multiplies the ground, drawn with `paint_efficiency` in full light, by the light on it.

    Camera and headlamps move together on a flat road, so the beam's share is worked out once; street lamps are added in
    each frame.
    """

    def __init__(self, camera: Camera, lamplight: Lamplight) -> None:
        self._lamplight = lamplight
        self._size = (camera.width_px, camera.height_px - ground_top(camera))
        columns = np.linspace(0.0, camera.width_px - 1.0, -(-camera.width_px // COLUMN_PX) + 1)
        farthest_px = road_row_px(camera, FARTHEST_M)
        rows = np.maximum(np.arange(ground_top(camera), camera.height_px, dtype=float), farthest_px)
        view = View.at(camera, np.zeros(2), 0.0)
        self._points_m = ground_points(view, columns, rows)
        self._beam_lx = ASPHALT * lamplight.beam_lx(view, self._points_m)
        self._beam = self._multiplier(self._beam_lx)

    def apply(self, ground: Image, view: View) -> None:
        """Light the rows of the ground, in place."""
        multiplier = self._beam
        lamps_m = self._lamplight.lamps_ahead(view, STREET_AHEAD_M)
        if len(lamps_m):
            street_lx = self._lamplight.street_lx(self._points_m.reshape(-1, 3), _in_ego_axes(view, lamps_m))
            multiplier = self._multiplier(self._beam_lx + street_lx.reshape(self._beam_lx.shape))
        cv2.multiply(ground, multiplier, ground, scale=LARGEST * BRIGHTEST / 255.0)

    def _multiplier(self, lux: Floats) -> Image:
        """(rows, W, 3) factor of each pixel, as 8 bits."""
        factor = self._lamplight.factor(lux).mean(axis=-1).astype(np.float32)
        small = np.minimum(factor * np.float32(255.0 / LARGEST) + np.float32(0.5), np.float32(255.0)).astype(np.uint8)
        full: Any = cv2.resize(small, self._size, interpolation=cv2.INTER_LINEAR)
        return np.asarray(cv2.cvtColor(full, cv2.COLOR_GRAY2RGB), np.uint8)


def ground_points(view: View, columns: Floats, rows: Floats) -> Floats:
    """(rows, columns, 3) m, world points of the ground at pixels."""
    x, y = np.meshgrid(columns, rows)
    points = np.stack([x, y, np.ones_like(x)], axis=-1) @ view.ground_homography().T
    points[..., :2] /= points[..., 2:]
    points[..., 2] = 0.0
    return np.asarray(points)


def _in_ego_axes(view: View, points_m: Floats) -> Floats:
    """(n, 3) world points ahead and right of the car's middle, and up."""
    c, s = cos(view.yaw_rad), sin(view.yaw_rad)
    x, y = (points_m[:, :2] - view.centre[:2]).T
    return np.stack([c * x + s * y + view.camera.forward_m, c * y - s * x, points_m[:, 2]], axis=1)


def paint_efficiency(wetness: float, beam_share: float) -> Floats:
    """(256,) brightness of the palette's values in the light of lamps, over that by day; 1 on dry paint in the beam.

    Paint returns light to the driver: 150 mcd/m2 for each lx (RW1), of white that returns 250 by day; 35 in the wet
    (EN 1436, class RW1). Grass stands upright in the beam and returns half of what it does by day. `beam_share` is the
    lamps' share of the light.
    """
    paint = PAINT / ASPHALT * (1.0 + (0.035 / 0.15 - 1.0) * wetness)
    grass = 0.5 / ASPHALT
    values = np.interp(np.arange(256), (0, 80, 112, 175, 222), (grass, grass, 1.0, 1.0, paint))
    return np.asarray((1.0 + (values - 1.0) * beam_share) ** (1.0 / GAMMA) / BRIGHTEST)
