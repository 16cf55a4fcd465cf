"""Sky, clouds and hills at infinity, on cylinders that turn with the yaw."""

import cv2
import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.sky.cylinder import Cylinder
from vpf_sim.envs.camera.sky.hills import hills, hills_show, outlines
from vpf_sim.envs.camera.sky.sky_dome import ZENITH_SLOPE, sky_dome
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.timing import timed
from vpf_sim.types import Camera, Floats, Image

COARSE = 4  # the sky is smooth: drawn on every fourth pixel


class Sky:
    """Draws all rows above the horizon: the sky dome, and below it the sky dome with hills."""

    def __init__(self, camera: Camera, light: Light, atmosphere: Atmosphere, seed: int) -> None:
        rng = stream(seed, "sky")
        sky = sky_dome(light, atmosphere, camera.fx_px / COARSE, rng)
        top, width = ground_top(camera), camera.width_px
        columns, rows = np.arange(width, dtype=float), np.arange(top, dtype=float)
        self._hills: Cylinder | None = None
        self._skyline = slice(top, top)
        if top and hills_show(atmosphere):
            tops = outlines(rng, detail(camera))
            turn, slope = _directions(camera, columns, rows)
            first = int(np.argmax((slope < tops.max()).any(axis=1)))
            tall, self._skyline = float(slope[first:].max()), slice(first, top)
            picture = hills(sky, tops, tall, light, atmosphere, rng)
            self._hills = Cylinder(picture, tall, turn[first:], slope[first:], 16)
        self._rows = self._skyline.start
        self._coarse = np.empty((-(-self._rows // COARSE), -(-width // COARSE), 3), np.uint8)
        self._sky: Cylinder | None = None
        if self._rows:
            rows, columns = (
                _middles(n, size) for n, size in zip(self._coarse.shape, (self._rows, width), strict=False)
            )
            self._sky = Cylinder(sky, ZENITH_SLOPE, *_directions(camera, columns, rows), 32)

    @timed("render.sky")
    def draw(self, view: View, frame: Image) -> None:
        """Draw the sky into the frame."""
        if self._sky is not None:
            self._sky.draw(view.yaw_rad, self._coarse)
            cv2.resize(self._coarse, (frame.shape[1], self._rows), frame[: self._rows])
        if self._hills is not None:
            self._hills.draw(view.yaw_rad, frame[self._skyline])


def _directions(camera: Camera, columns: Floats, rows: Floats) -> tuple[Floats, Floats]:
    """(rows, columns) angle right of the yaw, rad, and tangent of the elevation, of the pixels' rays."""
    right, down = np.meshgrid((columns - camera.cx_px) / camera.fx_px, (rows - camera.cy_px) / camera.fy_px)
    c, s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    ahead = c - s * down
    return np.arctan2(right, ahead), -(c * down + s) / np.hypot(right, ahead)


def _middles(count: int, size: int) -> Floats:
    """(count,) middles of coarse pixels in `size` fine pixels."""
    return (np.arange(count) + 0.5) * size / count - 0.5
