"""Creates the rasters of ground levels and samples image rows from them."""

from collections.abc import Callable

import cv2

from vpf_sim.envs.camera.ground.far_patch import FarPatch
from vpf_sim.envs.camera.ground.levels import Band, Level
from vpf_sim.envs.camera.ground.near_patch import NearPatch
from vpf_sim.envs.camera.ground.paint import GRASS
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.types import Camera, Floats, Image

WARP = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP

Patch = NearPatch | FarPatch


def patch_of(camera: Camera, level: Level, paint: Callable[[Raster], Image]) -> Patch:
    """The patch of a level, filled by `paint`."""
    return NearPatch(camera, level, paint) if level.steep else FarPatch(camera, level, paint)


def sample(patch: Patch, band: Band, to_world: Floats, target: Image, outside: int = GRASS) -> None:
    """Sample the rows of a band from a patch; `to_world` is the homography from image pixels to the ground.

    `outside` is the value beyond the patch.
    """
    matrix = patch.from_world @ to_world @ band.sampling
    if band.fineness == 1:
        cv2.warpPerspective(patch.pixels, matrix, target.shape[::-1], target, WARP, cv2.BORDER_CONSTANT, outside)
        return
    size = (target.shape[1], band.fineness * len(target))
    rows = cv2.warpPerspective(patch.pixels, matrix, size, flags=WARP, borderValue=outside)
    while len(rows) > 2 * len(target):
        rows = cv2.addWeighted(rows[0::2], 0.5, rows[1::2], 0.5, 0.0)
    cv2.addWeighted(rows[0::2], 0.5, rows[1::2], 0.5, 0.0, target)
