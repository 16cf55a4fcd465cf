"""Trees and bushes: billboards with images made from noise."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.tree_kinds import KINDS, Kind
from vpf_sim.envs.camera.texture import noise
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

ROWS, COLUMNS = 256, 192
SHAPE = COLUMNS / ROWS
MARGIN = 2  # transparent pixels around the image
SMALLEST_ROWS = 8  # of the coarsest mip level, about
NEAREST_M = 4.0
SAMPLED = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
NOTHING = (0, 0, 0, 255)
RANGE_M = 100.0  # drawing range
HEIGHTS_SEEN = 30.0  # and at most this many heights of the kind
FADED_IN = 0.72  # share of the range at which trees are opaque
HAZE_STEP_M = 0.5  # distance step of haze and fading
CLEAR_TRANSMISSION = 0.97  # haze with a higher transmission is left out
NOON = 0.85  # shading of the crown in the images
LOWEST_SUN = 0.1  # lowest sine of the altitude for shadow lengths
SHADOW_SIDES = 10
BARK = np.array([70.0, 60.0, 50.0])
STEP_M = 12.0  # travel of the camera before nearby trees are collected again
Indices = NDArray[np.int64]


VARIANTS, BUSHES = len(KINDS), 2
HEIGHTS_M = tuple(kind.height_m for kind in KINDS)
RANGES_M = tuple(min(RANGE_M, HEIGHTS_SEEN * kind.height_m) for kind in KINDS)


@dataclass(frozen=True, slots=True)
class Picture:
    """The cropped image of a tree; lengths are in heights of the tree."""

    left: float  # from the foot
    top: float  # from the foot, negative
    width: float
    height: float
    levels: tuple[Image, ...]  # (h, w, 4) premultiplied colours and transparency; mip levels


@lru_cache(maxsize=VARIANTS)
def tree_picture(variant: int) -> Picture:
    """The image of a tree in its reference light."""
    rng, kind = stream(0, f"tree {variant}"), KINDS[variant]
    y, x = np.mgrid[0:ROWS, 0:COLUMNS] / float(ROWS)
    coarse, ragged, leaves = (
        noise((ROWS, COLUMNS), rng, *spectrum) for spectrum in ((16.0, 1.2), (5.0, 0.8), (2.5, 0.2))
    )
    edges = np.array([1.0 - np.hypot((x - bx) / rx, (y - by) / ry) for bx, by, rx, ry in kind.crown])
    depth = edges.max(axis=0)
    alpha = np.clip((depth + kind.gaps * (0.5 * coarse + 0.3 * ragged + 0.2 * leaves) - 0.04) * 11.0, 0.0, 1.0)
    alpha *= np.clip((0.99 - y) * 40.0, 0.0, 1.0)
    # skylight: each lump of leaves is bright above and dark below
    lump = np.take_along_axis(_heights(kind, y), edges.argmax(axis=0)[None], axis=0)[0]
    bulge = 0.72 - 0.42 * lump - 0.25 * (x - 0.37) - 0.25 * np.clip(y - 0.4, 0.0, 1.0)
    bulge = np.clip(bulge + 0.16 * coarse + 0.2 * ragged + 0.16 * leaves, 0.16, 1.45)
    warm = np.array([0.10, 0.06, -0.04]) * np.clip(0.6 * coarse, -1.0, 1.0)[..., None]
    colour = np.array(kind.hue) * bulge[..., None] * (1.0 + warm)
    stem = np.zeros(y.shape, bool)
    for place, half in kind.stems:
        bend = place + 0.008 * np.sin(11.0 * y + 7.0 * place)
        stem |= (np.abs(x - bend) < half * (0.55 + 0.7 * y)) & (y > 0.35) & (y < 0.99)
    bark = BARK * np.clip(0.9 + 0.25 * leaves - 5.0 * (x - 0.37), 0.4, 1.4)[..., None]
    colour = np.where((stem & (alpha < 0.5))[..., None], bark, colour)
    alpha = np.maximum(alpha, stem)
    picture = np.dstack([colour * alpha[..., None], 255.0 * (1.0 - alpha)])
    return _cropped(np.clip(np.rint(picture), 0, 255).astype(np.uint8))


def _cropped(picture: Image) -> Picture:
    """An image (ROWS, COLUMNS, 4) cropped to its content, with mip levels."""
    rows, columns = (np.flatnonzero((picture[..., 3] < 255).any(axis=axis)) for axis in (1, 0))
    x0, x1 = max(int(columns[0]) - MARGIN, 0), int(columns[-1]) + 1 + MARGIN
    y0, y1 = max(int(rows[0]) - MARGIN, 0), int(rows[-1]) + 1 + MARGIN
    levels = [np.ascontiguousarray(picture[y0:y1, x0:x1])]
    height, width = levels[0].shape[:2]
    while levels[-1].shape[0] > SMALLEST_ROWS:
        size = (max(width >> len(levels), 1), max(height >> len(levels), 1))
        levels.append(np.asarray(cv2.resize(levels[0], size, interpolation=cv2.INTER_AREA), np.uint8))
    return Picture((x0 - 0.5 * COLUMNS) / ROWS, y0 / ROWS - 1.0, width / ROWS, height / ROWS, tuple(levels))


@dataclass(frozen=True, slots=True)
class Trees:
    """All trees of a road."""

    feet_m: Floats  # (T, 2) world
    heights_m: Floats  # (T,)
    variants: NDArray[np.int64]  # (T,)


def _heights(kind: Kind, y: Floats) -> Floats:
    """(blobs, ...) vertical position of rows in each lump of a crown: -1 top, +1 bottom."""
    return np.array([(y - by) / ry for _, by, _, ry in kind.crown])


def shadow_polygons(trees: Trees, light: Light) -> list[Floats]:
    """(n, 2) m, shadow outlines of all stems and lumps of leaves."""
    lean = light.sun[:2] / max(float(light.sun[2]), LOWEST_SUN)
    across = np.array([-lean[1], lean[0]]) / max(float(np.hypot(*lean)), 1e-9)
    circle = 2.0 * np.pi * np.arange(SHADOW_SIDES) / SHADOW_SIDES
    result = []
    for foot, height, variant in zip(trees.feet_m, trees.heights_m, trees.variants, strict=True):
        kind = KINDS[variant]
        for x, y, rx, ry in kind.crown:
            middle = foot + height * ((x - 0.5 * SHAPE) * across - (1.0 - y) * lean)
            along = np.hypot(rx, ry * np.hypot(*lean)) * lean / max(float(np.hypot(*lean)), 1e-9)
            rim = np.cos(circle)[:, None] * along + rx * np.sin(circle)[:, None] * across
            result.append(middle + height * rim)
        for x, half in kind.stems:
            low = foot + height * (x - 0.5 * SHAPE) * across
            high, wide = low - 0.6 * height * lean, height * half * across
            result.append(np.array([low - wide, low + wide, high + wide, high - wide]))
    return result
