"""Levels of detail of the ground: which image rows are sampled from which raster.

A pixel at depth d covers d / f of the ground across and d^2 / (f h) along it. Each level spans the depths from one
value to its double, on a raster with texels of about its nearest pixels' size. Levels blend where they meet: a hard
switch would draw a line that does not move in the image and looks like an obstacle where it crosses markings.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, log2, sin

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.types import Camera, Floats, Image

Indices = NDArray[np.int64]

RATIO = 2.0  # farthest over nearest depth of a level
LAST_M = 55.0  # a level that begins beyond this is the last; at full detail, as all distances of details
RANGE_M = 260.0  # nothing is painted beyond this
FADE, FADE_ROWS = 0.88, 2.5  # start of the blend as a share of the level's range, and its least rows
STEEP = 2.0  # levels nearer than this, in camera heights, use an even lattice
ACROSS, ALONG = 1.25, 1.75  # texels of the lattice, in pixels of the level's nearest row
SPARSE = 2.3  # most texels between sampled rows


@dataclass(frozen=True, slots=True)
class Band:
    """Rows of one level with one sampling rate, counted from the top of the ground."""

    first: int
    last: int  # exclusive
    fineness: int  # sampled rows per image row
    faded: bool  # blended over the previous level
    sampling: Floats  # (3, 3) from sampled pixels to image pixels


@dataclass(frozen=True, slots=True)
class Level:
    """One level of detail."""

    near_m: float  # depths
    far_m: float
    across_m: float  # its smallest pixel
    along_m: float
    steep: bool
    corners_m: Floats  # (4, 2) visible area, ahead and right of the camera's foot
    bands: list[Band]
    weights: Image  # (faded rows, W) blend weights, 255 is opaque


def levels(camera: Camera) -> list[Level]:
    """The levels of a camera, the farthest first."""
    top = ground_top(camera)
    if top == camera.height_px:
        return []
    inverse_depths = _inverse_depths(camera, np.array([camera.height_px - 0.5, top]))
    edges = [float(1.0 / inverse_depths[0])]
    last_m = LAST_M * detail(camera)
    while edges[-1] < last_m and edges[-1] * inverse_depths[1] < 1.0:
        edges.append(edges[-1] * RATIO)
    edges = [*edges[: max(1, len(edges) - 1)], np.inf]
    return [_level(camera, near, far) for near, far in reversed(list(pairwise(edges)))]


def _inverse_depths(camera: Camera, rows: Floats) -> Floats:
    """1/m, inverse depth of the road in rows; linear in the row."""
    y = (rows - camera.cy_px) / camera.fy_px
    return np.asarray((cos(camera.pitch_rad) * y + sin(camera.pitch_rad)) / camera.height_m)


def _level(camera: Camera, near: float, far: float) -> Level:
    inverse_depths = _inverse_depths(camera, np.arange(ground_top(camera), camera.height_px, dtype=float))
    opaque_from, hidden_from = _opaque_from(camera, far), _opaque_from(camera, near)
    shown = np.flatnonzero((inverse_depths > 1.0 / far) & (inverse_depths < hidden_from))
    share = (inverse_depths[shown] - 1.0 / far) / max(opaque_from - 1.0 / far, 1e-12)
    faded = int(np.count_nonzero(share < 1.0))
    weights = np.repeat(np.rint(255.0 * share[:faded]).astype(np.uint8)[:, None], camera.width_px, axis=1)
    across, along = near / camera.fx_px, near**2 / (camera.fy_px * camera.height_m)
    steep = near < STEEP * camera.height_m or far * detail(camera) < STEEP * camera.height_m
    sparse = inverse_depths[shown] ** -2.0 / near**2 / (SPARSE * ALONG) if steep else np.ones(len(shown))
    fineness = [2 ** max(0, ceil(log2(ratio))) for ratio in sparse]
    farthest = min(far, RANGE_M)
    corners = _corners(camera, 1.0 / hidden_from, farthest)
    return Level(near, farthest, across, along, steep, corners, _bands(camera, shown, faded, fineness), weights)


def _opaque_from(camera: Camera, far: float) -> float:
    """1/m, inverse depth from which a level up to `far` is opaque."""
    row = cos(camera.pitch_rad) / (camera.fy_px * camera.height_m)
    return max(1.0 / (FADE * far), 1.0 / far + FADE_ROWS * row) if np.isfinite(far) else 0.0


def _corners(camera: Camera, near: float, far: float) -> Floats:
    sides = (np.array([-1.0, camera.width_px]) - camera.cx_px) / camera.fx_px
    ahead = (np.array([near, far]) - camera.height_m * sin(camera.pitch_rad)) / cos(camera.pitch_rad)
    return np.array([(a, depth * side) for a, depth in zip(ahead, (near, far), strict=True) for side in sides])


def _bands(camera: Camera, shown: Indices, faded: int, fineness: list[int]) -> list[Band]:
    """The rows `shown` in bands of one sampling rate."""
    edges = [0, *(i for i in range(1, len(shown)) if fineness[i] != fineness[i - 1] or i == faded), len(shown)]
    return [
        _band(camera, int(shown[first]), int(shown[last - 1]) + 1, fineness[first], first < faded)
        for first, last in pairwise(edges)
        if last > first
    ]


def _band(camera: Camera, first: int, last: int, fineness: int, faded: bool) -> Band:
    start = ground_top(camera) + first - 0.5 + 0.5 / fineness
    sampling = np.array([[1.0, 0.0, 0.0], [0.0, 1.0 / fineness, start], [0.0, 0.0, 1.0]])
    return Band(first, last, fineness, faded, sampling)
