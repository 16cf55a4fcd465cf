"""How the ground is cut up by distance: which rows of the picture are taken from which raster of the road.

A pixel at the depth d covers d / f of the ground across and d^2 / (f h) along it, so each level holds the depths from
one value to its double, on a raster whose texels are about as large as its nearest pixels. Where two levels meet they
fade into each other: a hard switch would draw a line that stands still in the picture, and its crossings with markings
look like obstacles.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, log2, sin

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.types import Camera, Floats, Image

Indices = NDArray[np.int64]

RATIO = 2.0  # of the farthest to the nearest depth of a level
LAST_M = 55.0  # a level that begins beyond this is the last
RANGE_M = 260.0  # nothing is painted farther ahead
FADE, FADE_ROWS = 0.88, 2.5  # a level begins to give way at this part of its reach, and over as many rows at least
STEEP = 2.0  # a level that begins nearer than this is seen steeply enough for an even lattice, in camera heights
ACROSS, ALONG = 1.25, 1.75  # size of such a lattice's texels, in pixels of the level's nearest row
SPARSE = 2.3  # texels from one sampled row to the next, at most


@dataclass(frozen=True, slots=True)
class Band:
    """Rows of one level that are sampled equally finely; rows are counted from the top of the ground."""

    first: int
    last: int  # exclusive
    fineness: int  # rows sampled per row of the picture
    faded: bool  # lies over the level before
    sampling: Floats  # (3, 3) from pixels of the sampled rows to pixels of the picture


@dataclass(frozen=True, slots=True)
class Level:
    """One distance of the ground."""

    near_m: float  # depths
    far_m: float
    across_m: float  # its smallest pixel
    along_m: float
    steep: bool
    corners_m: Floats  # (4, 2) ahead of and right of the camera's foot: what the level shows
    bands: list[Band]
    weights: Image  # (faded rows, W) of this level, 255 = all


def levels(camera: Camera) -> list[Level]:
    """The levels of a camera, the farthest first."""
    top = ground_top(camera)
    if top == camera.height_px:
        return []
    falls = _falls(camera, np.array([camera.height_px - 0.5, top]))
    edges = [float(1.0 / falls[0])]
    while edges[-1] < LAST_M and edges[-1] * falls[1] < 1.0:
        edges.append(edges[-1] * RATIO)
    edges = [*edges[: max(1, len(edges) - 1)], np.inf]
    return [_level(camera, near, far) for near, far in reversed(list(pairwise(edges)))]


def _falls(camera: Camera, rows: Floats) -> Floats:
    """1/m, one over the depth at which rows meet the road; grows evenly from row to row."""
    y = (rows - camera.cy_px) / camera.fy_px
    return np.asarray((cos(camera.pitch_rad) * y + sin(camera.pitch_rad)) / camera.height_m)


def _level(camera: Camera, near: float, far: float) -> Level:
    falls = _falls(camera, np.arange(ground_top(camera), camera.height_px, dtype=float))
    whole, gone = _whole(camera, far), _whole(camera, near)
    shown = np.flatnonzero((falls > 1.0 / far) & (falls < gone))
    share = (falls[shown] - 1.0 / far) / max(whole - 1.0 / far, 1e-12)
    faded = int(np.count_nonzero(share < 1.0))
    weights = np.repeat(np.rint(255.0 * share[:faded]).astype(np.uint8)[:, None], camera.width_px, axis=1)
    across, along = near / camera.fx_px, near**2 / (camera.fy_px * camera.height_m)
    steep = near < STEEP * camera.height_m
    sparse = falls[shown] ** -2.0 / near**2 / (SPARSE * ALONG) if steep else np.ones(len(shown))
    fineness = [2 ** max(0, ceil(log2(ratio))) for ratio in sparse]
    farthest = min(far, RANGE_M)
    corners = _corners(camera, 1.0 / gone, farthest)
    return Level(near, farthest, across, along, steep, corners, _bands(camera, shown, faded, fineness), weights)


def _whole(camera: Camera, far: float) -> float:
    """1/m, one over the depth from which on a level that reaches to `far` is seen alone."""
    row = cos(camera.pitch_rad) / (camera.fy_px * camera.height_m)
    return max(1.0 / (FADE * far), 1.0 / far + FADE_ROWS * row) if np.isfinite(far) else 0.0


def _corners(camera: Camera, near: float, far: float) -> Floats:
    sides = (np.array([-1.0, camera.width_px]) - camera.cx_px) / camera.fx_px
    ahead = (np.array([near, far]) - camera.height_m * sin(camera.pitch_rad)) / cos(camera.pitch_rad)
    return np.array([(a, depth * side) for a, depth in zip(ahead, (near, far), strict=True) for side in sides])


def _bands(camera: Camera, shown: Indices, faded: int, fineness: list[int]) -> list[Band]:
    """The rows `shown` in stretches of one fineness."""
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
