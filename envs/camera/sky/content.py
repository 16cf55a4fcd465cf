"""Sky, clouds and hills as content of the core: panoramas that turn with the yaw."""

import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.sky.hills import hills, hills_show, outlines
from vpf_sim.envs.camera.sky.sky_dome import ZENITH_SLOPE, sky_dome
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

TEXEL_PX = 4  # the sky is smooth: a texel of its panorama, in the middle of the image
COARSE = 2  # and drawn on every second pixel; on every fourth, clouds seem to lag behind a turn


def add_sky(core: Core, light: Light, atmosphere: Atmosphere, seed: int) -> None:
    """Add the sky dome above the horizon, and below it the sky dome with hills."""
    camera, rng = core.camera, stream(seed, "sky")
    sky = sky_dome(light, atmosphere, camera.fx_px / TEXEL_PX, rng)
    top = ground_top(camera)
    first = top
    if top and hills_show(atmosphere):
        tops = outlines(rng, detail(camera))
        columns, rows = np.arange(camera.width_px, dtype=float), np.arange(top, dtype=float)
        _, slope = _directions(camera, columns, rows)
        first = int(np.argmax((slope < tops.max()).any(axis=1)))
        tall = float(slope[first:].max())
        _add(core, slice(first, top), 1, hills(sky, tops, tall, light, atmosphere, rng), tall)
    if first:
        _add(core, slice(0, first), COARSE, sky, ZENITH_SLOPE)


def _add(core: Core, rows: slice, coarse: int, panorama: Image, tall: float) -> None:
    """Add a panorama: column i is the azimuth 2 pi i / columns, rows fall from the tangent `tall` to 0."""
    camera = core.camera
    sampled = [_middles(extent, coarse) for extent in (camera.width_px, rows.stop - rows.start)]
    turn, slope = _directions(camera, sampled[0], rows.start + sampled[1])
    per_rad = panorama.shape[1] / (2.0 * np.pi)
    last = len(panorama) - 1
    down = np.clip(last * (1.0 - slope / tall), 0.0, last)
    core.add_panorama(rows, coarse, panorama, per_rad, turn * per_rad, down)


def _directions(camera: Camera, columns: Floats, rows: Floats) -> tuple[Floats, Floats]:
    """(rows, columns) angle right of the yaw, rad, and tangent of the elevation, of the pixels' rays."""
    right, down = np.meshgrid((columns - camera.cx_px) / camera.fx_px, (rows - camera.cy_px) / camera.fy_px)
    c, s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    ahead = c - s * down
    return np.arctan2(right, ahead), -(c * down + s) / np.hypot(right, ahead)


def _middles(extent: int, coarse: int) -> Floats:
    """The middles of coarse pixels that cover `extent` fine pixels."""
    return np.asarray((np.arange(-(-extent // coarse)) + 0.5) * coarse - 0.5)
