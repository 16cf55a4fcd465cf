"""Pictures of trees and bushes, made from noise; drawn as upright pictures that face the camera."""

from functools import lru_cache
from math import ceil, floor, log2

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import Sprite, premultiplied
from vpf_sim.envs.camera.texture import noise
from vpf_sim.envs.camera.veil import Veil
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

ROWS, COLUMNS = 256, 192
SHAPE = COLUMNS / ROWS
NEAREST_M = 4.0
VARIANTS = 8
RANGE_M, FADED_IN_M = 115.0, 85.0  # trees appear at the one and are there at the other
UNVEILED = 0.97  # air that leaves more of a tree's contrast does not show
NOON = 0.85  # the shading of a crown for which the pictures were mixed
Blob = tuple[float, float, float, float]  # centre x, y and radii, parts of the height

# For each shape of tree: its blobs (y from the top down), and the trunk's half width.
SHAPES: tuple[tuple[tuple[Blob, ...], float], ...] = (
    (((0.37, 0.34, 0.27, 0.28), (0.22, 0.48, 0.18, 0.18), (0.53, 0.46, 0.19, 0.20)), 0.022),  # broad crown
    (((0.37, 0.27, 0.20, 0.24), (0.34, 0.55, 0.25, 0.23), (0.43, 0.42, 0.23, 0.22)), 0.026),
    (((0.37, 0.40, 0.12, 0.39), (0.38, 0.62, 0.14, 0.26)), 0.018),  # poplar
    (((0.375, 0.60, 0.35, 0.36), (0.2, 0.74, 0.19, 0.23), (0.55, 0.72, 0.18, 0.24)), 0.0),  # bush
)


@lru_cache(maxsize=VARIANTS)
def tree_picture(variant: int) -> tuple[Image, ...]:
    """Picture `variant` at growing reduction, a factor of 2 each.

    Each is (h, w, 4): colours times opacity, and what it lets through.
    """
    rng = stream(0, f"tree {variant}")
    blobs, trunk = SHAPES[variant % len(SHAPES)]
    y, x = np.mgrid[0:ROWS, 0:COLUMNS] / float(ROWS)
    ragged, leaves = noise((ROWS, COLUMNS), rng, 5.0, 0.9), noise((ROWS, COLUMNS), rng, 3.0, 0.4)
    inside = np.max([1.0 - np.hypot((x - bx) / rx, (y - by) / ry) for bx, by, rx, ry in blobs], axis=0)
    alpha = np.clip((inside + 0.13 * ragged - 0.10) * 9.0, 0.0, 1.0) * (y < 0.985)
    bulge = np.clip(0.8 - 0.9 * (y - 0.35) - 0.35 * (x - 0.37) + 0.28 * ragged + 0.2 * leaves, 0.25, 1.5)
    hue = np.array([[72.0, 96.0, 44.0], [64.0, 88.0, 48.0], [84.0, 100.0, 46.0], [58.0, 80.0, 40.0]])[variant // 2 % 4]
    colour = hue * bulge[..., None]
    stem = (np.abs(x - 0.375 - 0.006 * np.sin(14.0 * y)) < trunk * (0.7 + 0.5 * y)) & (y > 0.4) & (y < 0.99)
    bark = np.array([74.0, 62.0, 50.0]) * np.clip(1.0 + 0.25 * leaves - 6.0 * (x - 0.375), 0.4, 1.5)[..., None]
    colour = np.where((stem & (alpha < 0.5))[..., None], bark, colour)
    alpha = np.maximum(alpha, stem)
    picture = np.dstack([colour * alpha[..., None], 255.0 * (1.0 - alpha)])
    pictures = [np.clip(np.rint(picture), 0, 255).astype(np.uint8)]
    while pictures[-1].shape[0] > 8:
        height, width = pictures[-1].shape[:2]
        pictures.append(cv2.resize(pictures[-1], (width // 2, height // 2), interpolation=cv2.INTER_AREA))
    return tuple(pictures)


class TreeStand:
    """The pictures of all trees in one light, seen through one air."""

    def __init__(self, light: Light, veil: Veil) -> None:
        tint = (light.sky + 0.5 * light.direct) / NOON
        scale = np.diag([*tint, 1.0])
        self._pictures = [
            tuple(np.asarray(cv2.transform(picture, scale), np.uint8) for picture in tree_picture(variant))
            for variant in range(VARIANTS)
        ]
        self._horizon = light.horizon
        self._veil = veil

    def seen(self, view: View, feet_m: Floats, heights_m: Floats, variants: NDArray[np.int64]) -> list[Sprite]:
        """The trees in view, the farthest first, of those whose feet (T, 3) are at these points of the world."""
        camera = view.camera
        right, down, depth = view.axes @ (feet_m - view.centre).T
        wide = 0.5 * camera.width_px / camera.fx_px * depth + 0.5 * SHAPE * heights_m
        index = np.flatnonzero((depth > NEAREST_M) & (depth < RANGE_M) & (np.abs(right) < wide))
        index = index[np.argsort(-depth[index], kind="stable")]
        right, down, depth = right[index], down[index], depth[index]
        tall = camera.fy_px * heights_m[index] / depth
        left = camera.cx_px + camera.fx_px * right / depth - 0.5 * SHAPE * tall
        top = camera.cy_px + camera.fy_px * down / depth - tall
        air = self._veil.transmission(depth)
        opacity = np.minimum(1.0, (RANGE_M - depth) / (RANGE_M - FADED_IN_M))
        rows = zip(*(a.tolist() for a in (left, top, tall, depth, air, opacity, variants[index])), strict=True)
        sprites = [self._sprite(camera, *row) for row in rows]
        return [sprite for sprite in sprites if sprite is not None]

    def _sprite(
        self,
        camera: Camera,
        left: float,
        top: float,
        tall: float,
        depth: float,
        air: float,
        opacity: float,
        variant: int,
    ) -> Sprite | None:
        x0, y0 = max(0, floor(left)), max(0, floor(top))
        x1 = min(camera.width_px, ceil(left + SHAPE * tall) + 1)
        y1 = min(camera.height_px, ceil(top + tall) + 1)
        if x0 >= x1 or y0 >= y1:
            return None
        pictures = self._pictures[variant]
        level = min(max(floor(log2(ROWS / tall)), 0), len(pictures) - 1)
        scale = tall / (ROWS >> level)
        place = np.array(((scale, 0.0, left + 0.5 * scale - x0), (0.0, scale, top + 0.5 * scale - y0)))
        size = (x1 - x0, y1 - y0)
        picture = np.asarray(cv2.warpAffine(pictures[level], place, size, borderValue=(0, 0, 0, 255)), np.uint8)
        if air < UNVEILED or opacity < 1.0:
            picture = self._faint(picture, air, opacity)
        return Sprite(x0, y0, *premultiplied(picture), depth)

    def _faint(self, picture: Image, air: float, opacity: float) -> Image:
        """A picture of which the air leaves a part of the contrast, and that is partly seen through."""
        matrix = np.zeros((4, 5))
        matrix[:3, :3] = opacity * air * np.eye(3)
        matrix[:3, 3] = -opacity * (1.0 - air) * self._horizon / 255.0
        matrix[:3, 4] = opacity * (1.0 - air) * self._horizon
        matrix[3, 3:] = opacity, 255.0 * (1.0 - opacity)
        return np.asarray(cv2.transform(picture, matrix), np.uint8)
