"""Pictures of trees and bushes, made from noise; drawn as upright pictures that face the camera."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, floor, log2

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.nearby import Nearby
from vpf_sim.envs.camera.painter import Sprite, premultiplied
from vpf_sim.envs.camera.texture import noise
from vpf_sim.envs.camera.veil import Veil
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

ROWS, COLUMNS = 256, 192
SHAPE = COLUMNS / ROWS
NEAREST_M = 4.0
SAMPLED = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
NOTHING = (0, 0, 0, 255)
RANGE_M, FADED_IN_M = 100.0, 72.0  # trees appear at the one and are there at the other
UNVEILED = 0.97  # air that leaves more of a tree's contrast does not show
NOON = 0.85  # the shading of a crown for which the pictures were mixed
LOWEST_SUN = 0.1  # sine of the altitude; lower suns cast no longer shadows
SHADOW_SIDES = 10
BARK = np.array([70.0, 60.0, 50.0])
Blob = tuple[float, float, float, float]  # centre x, y and radii, parts of the height; y from the top down


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of tree or bush."""

    height_m: float
    crown: tuple[Blob, ...]
    stems: tuple[tuple[float, float], ...]  # (x, half width) of each, parts of the height
    hue: tuple[float, float, float]  # RGB of a leaf in full light
    gaps: float  # how ragged the crown is


KINDS = (
    Kind(
        9.5,
        ((0.37, 0.30, 0.25, 0.24), (0.2, 0.44, 0.17, 0.16), (0.54, 0.43, 0.18, 0.18)),
        ((0.37, 0.022),),
        (78, 100, 48),
        0.3,
    ),
    Kind(
        8.0,
        ((0.37, 0.25, 0.19, 0.22), (0.33, 0.5, 0.25, 0.22), (0.45, 0.4, 0.22, 0.2)),
        ((0.38, 0.02),),
        (92, 106, 50),
        0.36,
    ),
    Kind(12.5, ((0.37, 0.36, 0.1, 0.35), (0.38, 0.62, 0.12, 0.25)), ((0.37, 0.016),), (66, 90, 46), 0.22),  # poplar
    Kind(
        11.0,
        ((0.37, 0.2, 0.1, 0.2), (0.37, 0.42, 0.17, 0.2), (0.37, 0.68, 0.24, 0.22)),
        ((0.37, 0.016),),
        (46, 70, 48),
        0.3,
    ),
    Kind(  # a clump of three
        10.0,
        ((0.2, 0.42, 0.17, 0.24), (0.42, 0.3, 0.18, 0.26), (0.58, 0.5, 0.15, 0.22), (0.4, 0.62, 0.2, 0.16)),
        ((0.2, 0.014), (0.42, 0.018), (0.58, 0.013)),
        (74, 94, 46),
        0.32,
    ),
    Kind(
        7.0, ((0.3, 0.32, 0.2, 0.26), (0.47, 0.4, 0.2, 0.24)), ((0.33, 0.012), (0.41, 0.012)), (104, 114, 58), 0.42
    ),  # birches
    Kind(2.4, ((0.37, 0.62, 0.33, 0.36), (0.2, 0.76, 0.18, 0.23), (0.56, 0.74, 0.17, 0.24)), (), (76, 96, 46), 0.3),
    Kind(1.6, ((0.2, 0.7, 0.2, 0.28), (0.48, 0.62, 0.24, 0.36), (0.6, 0.8, 0.14, 0.18)), (), (98, 104, 56), 0.4),
)
VARIANTS, BUSHES = len(KINDS), 2
HEIGHTS_M = tuple(kind.height_m for kind in KINDS)


@lru_cache(maxsize=VARIANTS)
def tree_picture(variant: int) -> tuple[Image, ...]:
    """Picture `variant` at growing reduction, a factor of 2 each.

    Each is (h, w, 4): colours times opacity, and what it lets through.
    """
    rng, kind = stream(0, f"tree {variant}"), KINDS[variant]
    y, x = np.mgrid[0:ROWS, 0:COLUMNS] / float(ROWS)
    coarse, ragged, leaves = (
        noise((ROWS, COLUMNS), rng, *spectrum) for spectrum in ((16.0, 1.2), (5.0, 0.8), (2.5, 0.2))
    )
    edges = np.array([1.0 - np.hypot((x - bx) / rx, (y - by) / ry) for bx, by, rx, ry in kind.crown])
    depth = edges.max(axis=0)
    alpha = np.clip((depth + kind.gaps * (0.5 * coarse + 0.3 * ragged + 0.2 * leaves) - 0.04) * 11.0, 0.0, 1.0)
    alpha *= np.clip((0.99 - y) * 40.0, 0.0, 1.0)
    # each lump of leaves is bright above and dark below, as the light from the sky falls
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
    pictures = [np.clip(np.rint(picture), 0, 255).astype(np.uint8)]
    while pictures[-1].shape[0] > 8:
        height, width = pictures[-1].shape[:2]
        pictures.append(cv2.resize(pictures[-1], (width // 2, height // 2), interpolation=cv2.INTER_AREA))
    return tuple(pictures)


@dataclass(frozen=True, slots=True)
class Trees:
    """All trees of a road."""

    feet_m: Floats  # (T, 2) world
    heights_m: Floats  # (T,)
    variants: NDArray[np.int64]  # (T,)


def _heights(kind: Kind, y: Floats) -> Floats:
    """(blobs, ...) where rows lie in each lump of a crown: -1 at its top, +1 at its bottom."""
    return np.array([(y - by) / ry for _, by, _, ry in kind.crown])


class TreeStand:
    """The trees of a road in one light, seen through one air."""

    def __init__(self, camera: Camera, trees: Trees, light: Light, veil: Veil) -> None:
        tint = (light.sky + 0.5 * light.direct) / NOON
        scale = np.diag([*tint, 1.0])
        self._pictures = [
            tuple(np.asarray(cv2.transform(picture, scale), np.uint8) for picture in tree_picture(variant))
            for variant in range(VARIANTS)
        ]
        self._veils = np.linspace(0.0, 1.0, 256)[:, None, None] * light.horizon  # of each opacity
        self._veil = veil
        radii = 0.5 * SHAPE * trees.heights_m
        self._nearby = Nearby(camera, trees.feet_m, radii, np.full(len(radii), RANGE_M))
        self._heights_m, self._variants = trees.heights_m.tolist(), trees.variants.tolist()
        self._feet_m = trees.feet_m.tolist()

    def seen(self, view: View) -> list[Sprite]:
        """The trees in view, the farthest first."""
        (rx, ry, _), (dx, dy, dz), (fx, fy, fz) = view.axes.tolist()
        x, y, z = view.centre.tolist()
        found = []
        for i in self._nearby.in_view(view)[0].tolist():
            ahead_x, ahead_y = self._feet_m[i][0] - x, self._feet_m[i][1] - y
            depth = fx * ahead_x + fy * ahead_y - fz * z
            if NEAREST_M < depth < RANGE_M:
                foot = (rx * ahead_x + ry * ahead_y, dx * ahead_x + dy * ahead_y - dz * z, depth)
                found.append((-depth, i, foot))
        found.sort()
        air = self._veil.transmission(np.array([-depth for depth, _, _ in found])).tolist()
        return [
            sprite
            for (_, i, foot), left in zip(found, air, strict=True)
            if (sprite := self._sprite(view.camera, foot, self._heights_m[i], self._variants[i], left)) is not None
        ]

    def shadow_polygons(self, light: Light) -> list[Floats]:
        """(n, 2) m, outlines on the ground of the shades of all stems and lumps of leaves."""
        lean = light.sun[:2] / max(float(light.sun[2]), LOWEST_SUN)
        across = np.array([-lean[1], lean[0]]) / max(float(np.hypot(*lean)), 1e-9)
        circle = 2.0 * np.pi * np.arange(SHADOW_SIDES) / SHADOW_SIDES
        result = []
        for foot, height, variant in zip(self._feet_m, self._heights_m, self._variants, strict=True):
            kind = KINDS[variant]
            for x, y, rx, ry in kind.crown:
                middle = np.array(foot) + height * ((x - 0.5 * SHAPE) * across - (1.0 - y) * lean)
                along = np.hypot(rx, ry * np.hypot(*lean)) * lean / max(float(np.hypot(*lean)), 1e-9)
                rim = np.cos(circle)[:, None] * along + rx * np.sin(circle)[:, None] * across
                result.append(middle + height * rim)
            for x, half in kind.stems:
                low = np.array(foot) + height * (x - 0.5 * SHAPE) * across
                high, wide = low - 0.6 * height * lean, height * half * across
                result.append(np.array([low - wide, low + wide, high + wide, high - wide]))
        return result

    def _sprite(
        self, camera: Camera, foot: tuple[float, float, float], height_m: float, variant: int, air: float
    ) -> Sprite | None:
        """A tree whose foot is at a point in camera axes, of whose contrast the air leaves a part."""
        right, down, depth = foot
        tall = camera.fy_px * height_m / depth
        left = camera.cx_px + camera.fx_px * right / depth - 0.5 * SHAPE * tall
        top = camera.cy_px + camera.fy_px * down / depth - tall
        x0, y0 = max(0, floor(left)), max(0, floor(top))
        x1 = min(camera.width_px, ceil(left + SHAPE * tall) + 1)
        y1 = min(camera.height_px, ceil(top + tall) + 1)
        if x0 >= x1 or y0 >= y1:
            return None
        pictures = self._pictures[variant]
        level = min(max(floor(log2(ROWS / tall)), 0), len(pictures) - 1)
        scale = tall / (ROWS >> level)
        finer = 1.0 / scale
        right_by, down_by = (x0 - left + 0.5) * finer - 0.5, (y0 - top + 0.5) * finer - 0.5
        source = np.array(((finer, 0.0, right_by), (0.0, finer, down_by)))  # of each pixel
        picture = cv2.warpAffine(pictures[level], source, (x1 - x0, y1 - y0), flags=SAMPLED, borderValue=NOTHING)
        colour, through = premultiplied(picture)
        if air < UNVEILED or depth > FADED_IN_M:
            opacity = min(1.0, (RANGE_M - depth) / (RANGE_M - FADED_IN_M))
            colour, through = self._faint(colour, through, air, opacity)
        return Sprite(x0, y0, colour, through, depth)

    def _faint(self, colour: Image, through: Image, air: float, opacity: float) -> tuple[Image, Image]:
        """A picture of which the air leaves a part of the contrast, and that is partly seen through."""
        covered = cv2.bitwise_not(cv2.extractChannel(through, 0))
        veil = cv2.applyColorMap(covered, np.rint(opacity * (1.0 - air) * self._veils).astype(np.uint8))
        return (
            np.asarray(cv2.addWeighted(colour, opacity * air, veil, 1.0, 0.0), np.uint8),
            np.asarray(cv2.convertScaleAbs(through, alpha=opacity, beta=255.0 * (1.0 - opacity)), np.uint8),
        )
