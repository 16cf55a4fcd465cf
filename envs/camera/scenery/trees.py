"""Trees and bushes: billboards with images made from noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.night.lit_trees import lit, tree_factors
from vpf_sim.envs.camera.painter import Sprite
from vpf_sim.envs.camera.scenery.tree_kinds import KINDS, Kind
from vpf_sim.envs.camera.texture import noise
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

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
FADED_PICTURES = 512  # cached hazed images
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


@dataclass(frozen=True, slots=True)
class _Near:
    """Trees near the camera, with their images' offsets from the feet."""

    variants: Indices
    ranges_m: Floats  # (n,) drawing ranges
    feet_m: Floats  # (2, n) world
    left_m: Floats  # (n,)
    top_m: Floats
    width_m: Floats
    height_m: Floats

    @classmethod
    def of(cls, trees: Trees, frames_m: Floats, index: Indices) -> "_Near":
        variants = trees.variants[index]
        feet_m = np.ascontiguousarray(trees.feet_m[index].T)
        return cls(variants, np.array(RANGES_M)[variants], feet_m, *np.ascontiguousarray(frames_m[index].T))


class TreeStand:
    """The trees of a road in one light and haze."""

    def __init__(
        self, camera: Camera, trees: Trees, light: Light, haze: Haze, lamplight: Lamplight | None = None
    ) -> None:
        """`lamplight` is the light of lamps in the dark, None by day."""
        self._lamplight = lamplight
        tint = (light.sky + 0.5 * light.direct) / NOON if lamplight is None else np.ones(3)
        scale = np.diag([*tint, 1.0])
        pictures = [tree_picture(variant) for variant in range(VARIANTS)]
        self._levels = [[np.asarray(cv2.transform(level, scale), np.uint8) for level in p.levels] for p in pictures]
        shapes = [[level.shape[1::-1] for level in p.levels] for p in pictures]
        self._coarsest = np.array([len(p.levels) - 1 for p in pictures])
        self._rows = np.array([p.levels[0].shape[0] for p in pictures], float)
        self._sizes = np.ones((2, VARIANTS, int(self._coarsest.max()) + 1))  # (columns, rows) of each level
        for variant, shape in enumerate(shapes):
            self._sizes[:, variant, : len(shape)] = np.array(shape).T
        self._limits = np.array([[camera.width_px], [camera.height_px]], float)
        self._haze_transforms = [_haze_transforms(range_m, light, haze) for range_m in RANGES_M]
        self._hazed_pictures: dict[tuple[int, int, int], Image] = {}  # hazed images, the oldest first
        self._trees = trees
        frames = np.array([(p.left, p.top, p.width, p.height) for p in pictures])
        self._frames_m = frames[trees.variants] * trees.heights_m[:, None]
        self._slope = 0.5 * camera.width_px / camera.fx_px  # slope of the field of view's sides
        self._middle = np.full(2, np.inf)
        self._near = _Near.of(trees, self._frames_m, np.empty(0, np.int64))

    def visible(self, view: View) -> list[Sprite]:
        """The visible trees, the farthest first."""
        variants, depth, corner, size, feet_m = self._in_view(view)
        first = np.maximum(np.floor(corner), 0.0)
        extent = np.minimum(np.ceil(corner + size), self._limits) - first
        levels = np.floor(np.log2(self._rows[variants] / size[1])).clip(0, self._coarsest[variants]).astype(np.int64)
        fine = self._sizes[:, variants, levels] / size  # image pixels per frame pixel
        sources = np.zeros((len(depth), 2, 3))
        sources[:, 0, 0], sources[:, 1, 1] = fine
        sources[:, :, 2] = ((first - corner + 0.5) * fine - 0.5).T
        kinds = np.array((variants, levels, depth / HAZE_STEP_M), np.int64).T.tolist()
        places = np.concatenate((first, extent)).astype(np.int64).T.tolist()
        factors: Sequence[Floats | None] = [None] * len(kinds)
        if self._lamplight is not None:
            factors = list(tree_factors(self._lamplight, view, feet_m.T, depth, first[1], extent[1]))
        return [
            Sprite(x, y, self._sampled(kind, source, (columns, rows), factor), far)
            for kind, source, (x, y, columns, rows), far, factor in zip(
                kinds, sources, places, depth.tolist(), factors, strict=True
            )
            if columns > 0 and rows > 0
        ]

    def _in_view(self, view: View) -> tuple[Indices, Floats, Floats, Floats, Floats]:
        """Variants (n,), depths (n,), corners (2, n) px, sizes (2, n) px and feet (2, n) m of the visible trees."""
        camera, near = view.camera, self._near_trees(view.centre[:2])
        right, down, depth = view.axes[:, :2] @ near.feet_m - (view.axes @ view.centre)[:, None]
        left = right + near.left_m
        wide = self._slope * depth
        shown = (depth > NEAREST_M) & (depth < near.ranges_m) & (left < wide) & (left + near.width_m > -wide)
        index = shown.nonzero()[0]
        index = index[np.argsort(-depth[index], kind="stable")]
        depth = depth[index]
        place = np.array((left, down + near.top_m, near.width_m, near.height_m)).take(index, axis=1)
        place *= camera.fy_px / depth
        middle = ((camera.cx_px,), (camera.cy_px,))
        return near.variants[index], depth, np.add(place[:2], middle), place[2:], near.feet_m[:, index]

    def shadow_polygons(self, light: Light) -> list[Floats]:
        """(n, 2) m, shadow outlines of all stems and lumps of leaves."""
        lean = light.sun[:2] / max(float(light.sun[2]), LOWEST_SUN)
        across = np.array([-lean[1], lean[0]]) / max(float(np.hypot(*lean)), 1e-9)
        circle = 2.0 * np.pi * np.arange(SHADOW_SIDES) / SHADOW_SIDES
        result = []
        trees = self._trees
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

    def _near_trees(self, eye: Floats) -> "_Near":
        """The trees that may be visible near a position, updated as the camera moves."""
        if not np.hypot(*(eye - self._middle).tolist()) < STEP_M:
            reach_m = RANGE_M * np.hypot(1.0, self._slope) + STEP_M + self._trees.heights_m
            close = np.hypot(*(self._trees.feet_m - eye).T) < reach_m
            self._middle, self._near = eye, _Near.of(self._trees, self._frames_m, np.flatnonzero(close))
        return self._near

    def _sampled(self, kind: list[int], source: Floats, size: tuple[int, int], factors: Floats | None) -> Image:
        """(rows, columns, 4) the image of `kind` (variant, level, haze step), sampled by the affine `source` (2, 3).

        `factors` are those of the light of lamps, None by day.
        """
        variant, level, step = kind
        picture = self._hazed(*kind) if factors is None else self._levels[variant][level]
        sampled = np.asarray(cv2.warpAffine(picture, source, size, flags=SAMPLED, borderValue=NOTHING), np.uint8)
        if factors is None:
            return sampled
        shown, transform = lit(sampled, factors), self._haze_transforms[variant][step]
        return shown if transform is None else np.asarray(cv2.transform(shown, transform), np.uint8)

    def _hazed(self, variant: int, level: int, step: int) -> Image:
        """(h, w, 4) an image with the haze of a distance step, cached."""
        key = (variant, level, step)
        if key not in self._hazed_pictures:
            if len(self._hazed_pictures) == FADED_PICTURES:
                del self._hazed_pictures[next(iter(self._hazed_pictures))]
            picture, transform = self._levels[variant][level], self._haze_transforms[variant][step]
            self._hazed_pictures[key] = (
                picture if transform is None else np.asarray(cv2.transform(picture, transform), np.uint8)
            )
        return self._hazed_pictures[key]


def _haze_transforms(range_m: float, light: Light, haze: Haze) -> list[Floats | None]:
    """(4, 5) affine channel transforms for haze and fading, by distance step; None for identity.

    A pixel of coverage a and premultiplied colour a c, at transmission t and tree opacity o, becomes
    o (t a c + (1 - t) a h), with the horizon's colour h, and the transparency 1 - o a.
    """
    depths_m: Floats = (np.arange(ceil(range_m / HAZE_STEP_M), dtype=np.float64) + 0.5) * HAZE_STEP_M
    left = haze.transmission(depths_m)
    opacity = np.clip((range_m - depths_m) / (range_m * (1.0 - FADED_IN)), 0.0, 1.0)
    airlight = (opacity * (1.0 - left))[:, None] * light.horizon
    matrices = np.zeros((len(depths_m), 4, 5))
    for channel in range(3):
        matrices[:, channel, channel] = opacity * left
    matrices[:, 3, 3] = opacity
    matrices[:, :3, 3], matrices[:, :3, 4] = -airlight / 255.0, airlight
    matrices[:, 3, 4] = 255.0 * (1.0 - opacity)
    shows = (left < CLEAR_TRANSMISSION) | (opacity < 1.0)
    return [matrix if shown else None for matrix, shown in zip(matrices, shows.tolist(), strict=True)]
