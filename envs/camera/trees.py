"""Pictures of trees and bushes, made from noise; drawn as upright pictures that face the camera."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, floor, log2

import cv2
import numpy as np

from vpf_sim.envs.camera.texture import noise
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

ROWS, COLUMNS = 256, 192
VARIANTS = 8
Blob = tuple[float, float, float, float]  # centre x, y and radii, parts of the height

# For each shape of tree: its blobs (y from the top down), and the trunk's half width.
SHAPES: tuple[tuple[tuple[Blob, ...], float], ...] = (
    (((0.37, 0.34, 0.27, 0.28), (0.22, 0.48, 0.18, 0.18), (0.53, 0.46, 0.19, 0.20)), 0.022),  # broad crown
    (((0.37, 0.27, 0.20, 0.24), (0.34, 0.55, 0.25, 0.23), (0.43, 0.42, 0.23, 0.22)), 0.026),
    (((0.37, 0.40, 0.12, 0.39), (0.38, 0.62, 0.14, 0.26)), 0.018),  # poplar
    (((0.375, 0.60, 0.35, 0.36), (0.2, 0.74, 0.19, 0.23), (0.55, 0.72, 0.18, 0.24)), 0.0),  # bush
)


@dataclass(frozen=True, slots=True)
class Sprite:
    """Where an upright picture was drawn."""

    x: int
    y: int
    colour: Image  # (h, w, 3) colours times opacity
    through: Image  # (h, w, 3) what is seen through it, of 255
    depth_m: float


@lru_cache(maxsize=VARIANTS)
def tree_picture(variant: int) -> tuple[tuple[Image, Image], ...]:
    """Picture `variant` at growing reduction, a factor of 2 each: colours times opacity, and what it lets through.

    Both are (h, w, 3), so that two operations on whole pictures draw it.
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
    rgba = np.dstack([colour * alpha[..., None], 255.0 * alpha])
    pictures = [np.clip(np.rint(rgba), 0, 255).astype(np.uint8)]
    while pictures[-1].shape[0] > 8:
        height, width = pictures[-1].shape[:2]
        pictures.append(cv2.resize(pictures[-1], (width // 2, height // 2), interpolation=cv2.INTER_AREA))
    return tuple(
        (np.ascontiguousarray(p[..., :3]), np.ascontiguousarray(np.repeat(255 - p[..., 3:], 3, axis=2)))
        for p in pictures
    )


def tree_sprite(view: View, foot_camera: Floats, height_m: float, variant: int) -> Sprite | None:
    """A tree of a height whose foot is at a point in camera axes; None if it is out of the picture."""
    camera, (right, down, depth) = view.camera, foot_camera.tolist()
    tall = camera.fy_px * height_m / depth
    left = camera.cx_px + camera.fx_px * right / depth - 0.5 * COLUMNS / ROWS * tall
    top = camera.cy_px + camera.fy_px * down / depth - tall
    pictures = tree_picture(variant)
    level = min(max(floor(log2(ROWS / tall)), 0), len(pictures) - 1)
    scale = tall / (ROWS >> level)
    x0, y0 = max(0, floor(left)), max(0, floor(top))
    x1 = min(camera.width_px, ceil(left + COLUMNS / ROWS * tall) + 1)
    y1 = min(camera.height_px, ceil(top + tall) + 1)
    if x0 >= x1 or y0 >= y1:
        return None
    place = np.array([[scale, 0.0, left + 0.5 * scale - x0], [0.0, scale, top + 0.5 * scale - y0]])
    size = (x1 - x0, y1 - y0)
    colour, through = pictures[level]
    behind = cv2.warpAffine(through, place, size, flags=cv2.INTER_LINEAR, borderValue=(255, 255, 255))
    leaves = cv2.warpAffine(colour, place, size, flags=cv2.INTER_LINEAR)
    return Sprite(x0, y0, np.asarray(leaves, np.uint8), np.asarray(behind, np.uint8), depth)


def paint_sprite(frame: Image, sprite: Sprite) -> None:
    """Draw an upright picture over the picture."""
    height, width = sprite.through.shape[:2]
    region = frame[sprite.y : sprite.y + height, sprite.x : sprite.x + width]
    cv2.multiply(region, sprite.through, region, scale=1 / 255)
    cv2.add(region, sprite.colour, region)
