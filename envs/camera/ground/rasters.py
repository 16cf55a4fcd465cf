"""The rasters of the ground's levels: their sizes, and the anchors in the world at which they are painted.

A near level has an even lattice from above. A far one has the image of a camera a little ahead or behind: a distant
pixel covers much more ground along its ray than across, and on an even lattice averaged grain would be stretched along
the flow. Anchors depend on the pose alone: headings and steps are rounded, and neighbouring levels have shifted grids,
so that few are painted in the same frame.
"""

from dataclasses import dataclass, field
from itertools import product
from math import ceil, cos, floor, pi, sin

import numpy as np

from vpf_sim.envs.camera.ground.levels import ACROSS, ALONG, Level
from vpf_sim.envs.camera.view import NEAR_M
from vpf_sim.geometry import horizon_px
from vpf_sim.types import Camera, Floats

HALF = 0.5  # most distance of a pose from its anchor, in turns, steps and sidesteps
NEAR_TURN_RAD, FAR_TURN_RAD = pi / 26, 0.06  # between headings
NEAR_STEP, NEAR_SIDESTEP = 0.3, 0.3  # between anchors, in the level's nearest depth
FAR_STEP, FAR_SIDESTEP = 0.38, 0.12
GOLDEN = 0.618  # shift between the grids of levels
ROWS = 1.25  # texels per row of pixels
HIGHEST = 0.45  # px, the first texels' middles below the horizon: a corner above it would lie behind the camera
COLUMNS = 8  # columns come in multiples: a sample of the coarsest grain


@dataclass(frozen=True, slots=True)
class RasterShape:
    """A level's raster; lengths in m, or texels where a near level steps by them."""

    rows: int
    columns: int
    across_m: float
    along_m: float
    turn_rad: float
    step: float
    sidestep: float
    ahead_m: float = 0.0  # from the camera to a near raster's first texel
    right_m: float = 0.0
    phase: float = 0.0
    depth_scale: float = 1.0  # of a far raster: puts the near plane well before the visible range
    to_texels: Floats = field(default_factory=lambda: np.eye(3))  # (3, 3) of a far raster, from the anchor's pixels


def raster_shape(camera: Camera, level: Level) -> RasterShape:
    """The raster of a level."""
    return _near(level) if level.steep else _far(camera, level)


def _near(level: Level) -> RasterShape:
    across, along = ACROSS * level.across_m, ALONG * level.along_m
    turn = HALF * NEAR_TURN_RAD
    turned = np.concatenate([_turned(level.corners_m, angle) for angle in (-turn, 0.0, turn)])
    (ahead, right), (farthest, rightmost) = turned.min(axis=0), turned.max(axis=0)
    step = max(1, round(NEAR_STEP * level.near_m / along))
    sidestep = max(1, round(NEAR_SIDESTEP * level.near_m / across))
    blocks = ceil((ceil((farthest - ahead) / along) + 3) / step) + 1
    columns = ceil((rightmost - right) / across) + 4 + 2 * sidestep
    return RasterShape(
        blocks * step, _whole(columns), across, along, NEAR_TURN_RAD, step, sidestep, float(ahead), float(right)
    )


def _far(camera: Camera, level: Level) -> RasterShape:
    step, sidestep = FAR_STEP * level.near_m, FAR_SIDESTEP * level.near_m
    (left, top), (right, bottom) = _bounds(camera, level, step, sidestep)
    first, left = max(floor(top), horizon_px(camera) + HIGHEST), floor(left)
    to_texels = np.array([[1.0, 0.0, -left], [0.0, ROWS, -ROWS * first], [0.0, 0.0, 1.0]])
    return RasterShape(
        rows=ceil(ROWS * (bottom - first)) + 2,
        columns=_whole(ceil(right - left) + 2),
        across_m=level.across_m,
        along_m=level.along_m / ROWS,
        turn_rad=FAR_TURN_RAD,
        step=step,
        sidestep=sidestep,
        phase=GOLDEN * level.near_m % 1.0,
        depth_scale=camera.height_m * NEAR_M / (0.5 * level.near_m),
        to_texels=to_texels,
    )


def _bounds(camera: Camera, level: Level, step: float, sidestep: float) -> Floats:
    """(2, 2) px, least and largest column and row of a level over all poses that share an anchor."""
    found = []
    for turn, ahead, right in product((-HALF * FAR_TURN_RAD, HALF * FAR_TURN_RAD), (-HALF, HALF), (-HALF, HALF)):
        points = _turned(level.corners_m, -turn)
        points += (ahead * step, right * sidestep)
        depth = points[:, 0] * cos(camera.pitch_rad) + camera.height_m * sin(camera.pitch_rad)
        down = (camera.height_m / depth - sin(camera.pitch_rad)) / cos(camera.pitch_rad)
        found.append([camera.cx_px + camera.fx_px * points[:, 1] / depth, camera.cy_px + camera.fy_px * down])
    pixels = np.concatenate(found, axis=1)
    return np.array([pixels.min(axis=1), pixels.max(axis=1)])


def _turned(points: Floats, angle: float) -> Floats:
    c, s = cos(angle), sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def _whole(columns: int) -> int:
    return COLUMNS * ceil(columns / COLUMNS)
