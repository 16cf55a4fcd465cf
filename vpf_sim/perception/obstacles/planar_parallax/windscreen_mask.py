"""Which cells of a patch of road, laid out from a frame, show no road: water on the glass, or what the film mirrors.

A drop stays where it is in the picture, and so in its layout, while the road moves on behind it. Where the slopes of
brightness along the way agree in two layouts taken at different places, cell by cell, and better than when the older is
moved as the road has, something that stays hides the road. So does the mirror image of what is far off. A line along
the way has no such slope.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.perception.obstacles.planar_parallax.temporal_average import Grid
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Image

SPARSE = slice(None, None, 3)  # windows overlap: a few tell


@dataclass(frozen=True, slots=True)
class WindscreenMaskConfig:
    """What stays. Sizes are along and across."""

    least_way_m: float = 0.3  # of the car between two layouts
    texture_m: float = 0.15  # of the road, over which brightness is averaged
    window_m: tuple[float, float] = (0.45, 0.25)  # over which they are compared
    share: float = 0.6  # of what is seen there, that both have in common,
    lead: float = 0.5  # so much of it more than when the older is moved: far away pixels are longer than the way, and
    contrast: float = 4.0  # times the median of its power, that it needs,
    floor_levels2: float = 3.0  # and at least this power: the grain of asphalt agrees by chance
    rim_m: tuple[float, float] = (0.45, 0.25)  # about it that is hidden as well, half to each side

    def __post_init__(self) -> None:
        if self.least_way_m <= 0.0 or self.contrast <= 0.0 or not 0.0 < self.share < 1.0:
            raise ValueError(f"least_way_m, contrast: expected > 0; share: expected between 0 and 1; got {self}")


def texture(patch: Image, cell_m: float, config: WindscreenMaskConfig) -> Grid:
    """(rows, columns) grey levels in two cells, how the brightness changes along the way."""
    size = odd_cells(config.texture_m, cell_m)
    smooth = cv2.blur(patch.astype(np.float32), (3, size))
    return np.asarray(cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=1), np.float32)


def static_texture(now: Grid, before: Grid, moved: Grid, cell_m: float, config: WindscreenMaskConfig) -> Image:
    """(rows, columns) 1 where the textures of two layouts agree although the car has moved between them, else 0.

    `moved` is the texture `before`, moved as the road has: what agrees with it better is on the road.
    """
    window = (odd_cells(config.window_m[1], cell_m), odd_cells(config.window_m[0], cell_m))
    power = np.asarray(cv2.blur(0.5 * (now * now + before * before), window), np.float32)
    common = cv2.blur(now * before, window)
    stays = (common > config.share * power) & (common > cv2.blur(now * moved, window) + config.lead * power)
    stays &= power > max(config.contrast * median(power[SPARSE, SPARSE]), config.floor_levels2)
    rim = np.ones((odd_cells(config.rim_m[0], cell_m), odd_cells(config.rim_m[1], cell_m)), np.uint8)
    return np.asarray(cv2.dilate(stays.astype(np.uint8), rim), np.uint8)


def odd_cells(size_m: float, cell_m: float) -> int:
    """Cells, an odd number."""
    return 2 * round(0.5 * (size_m / cell_m - 1.0)) + 1
