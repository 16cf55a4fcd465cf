"""Mask of static texture: cells of a patch of road that show water on the windscreen or far mirror images.

A drop stays where it is in the image, and so in its layout, while the road moves. Static texture agrees, cell by cell,
in two layouts taken at different places, and better than when the older is moved as the road has. Texture is the slope
of brightness along the way, which a line along the way does not have.
"""

import cv2
import numpy as np

from vpf_sim.perception.obstacles.planar_parallax.config import WindscreenMaskConfig, odd_cells
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Image, Singles


def texture(patch: Image, cell_m: float, config: WindscreenMaskConfig) -> Singles:
    """(rows, columns) slope of brightness along the way, grey levels in two cells."""
    _, size = odd_cells((config.texture_m, cell_m), cell_m)
    smooth = cv2.blur(patch.astype(np.float32), (3, size))
    return np.asarray(cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=1), np.float32)


def static_texture(now: Singles, before: Singles, moved: Singles, cell_m: float, config: WindscreenMaskConfig) -> Image:
    """(rows, columns) 1 where the textures of two layouts agree although the car has moved, else 0.

    `moved` is the texture `before`, moved as the road has: what agrees with it better is on the road.
    """
    window = odd_cells(config.window_m, cell_m)
    power = np.asarray(cv2.blur(0.5 * (now * now + before * before), window), np.float32)
    common = cv2.blur(now * before, window)
    stays = common > config.share * power
    if config.road_motion is not None:
        stays &= common > cv2.blur(now * moved, window) + config.road_motion.lead * power
    stays &= power > max(config.contrast * median(power[::3, ::3]), config.floor_levels2)
    masked = stays.astype(np.uint8)
    if config.rim is None:
        return masked
    rim = np.ones(odd_cells(config.rim.size_m, cell_m)[::-1], np.uint8)
    return np.asarray(cv2.dilate(masked, rim), np.uint8)
