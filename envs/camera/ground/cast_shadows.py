"""Shadows that the scenery casts on the ground: a mask on the rasters of the ground's levels."""

from collections.abc import Callable

import cv2
import numpy as np

from vpf_sim.envs.camera.ground.levels import Level
from vpf_sim.envs.camera.ground.paint import Batch
from vpf_sim.envs.camera.ground.patches import Patch, patch_of
from vpf_sim.envs.camera.ground.surface import Polygons, Surface
from vpf_sim.types import Camera, Floats, Image

LIT, SHADED = 0, 255  # of the mask
SMALLEST_M2 = 0.01  # smaller polygons are left out


def shadow_batches(outlines: list[Floats]) -> list[Batch]:
    """Convex polygons (V, 2) m as batches of one vertex count; each is a strip of its own, since they overlap."""
    batches = []
    for count in sorted({len(outline) for outline in outlines}):
        polygons = np.array([outline for outline in outlines if len(outline) == count])
        polygons = polygons[_areas_m2(polygons) > SMALLEST_M2]
        if len(polygons):
            values = np.full(len(polygons), SHADED, np.int64)
            batches.append(Batch(polygons, values, np.arange(len(polygons)), thin=False))
    return batches


def shadow_patches(
    camera: Camera, levels: list[Level], outlines: list[Floats], fine: Callable[[Level], tuple[int, int]]
) -> list[Patch]:
    """A patch per level with the mask of the shadows, 0 in the sun and 255 in full shadow."""
    polygons = Polygons(shadow_batches(outlines))
    surfaces = [Surface(polygons, level.near_m, fine(level), outside=LIT) for level in levels]
    return [patch_of(camera, level, surface.paint) for level, surface in zip(levels, surfaces, strict=True)]


def darken(frame: Image, mask: Image, left: float) -> None:
    """Multiply rows (H, W, 3) in place by `left` where the mask (H, W) is 255, and by less change where it is less."""
    share = cv2.convertScaleAbs(mask, None, left - 1.0, 255.0)
    cv2.multiply(frame, cv2.cvtColor(share, cv2.COLOR_GRAY2BGR), frame, scale=1 / 255)


def _areas_m2(polygons: Floats) -> Floats:
    """(n,) areas of polygons (n, V, 2)."""
    x, y = polygons[..., 0], polygons[..., 1]
    twice = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    return np.asarray(0.5 * np.abs(twice))
