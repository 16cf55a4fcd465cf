"""The grain of road and verge at every distance.

Each level shows two grain sizes, its own and the next level's, so that levels that blend share one. A size is one noise
field fixed to the world by a seed; frequencies too high for a texel are averaged out.
"""

from math import ceil, log2

import cv2
import numpy as np

from vpf_sim.envs.camera.ground.far_patch import ROWS
from vpf_sim.envs.camera.ground.levels import ALONG, Level
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.texture import TILE, grain_tile
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

SIZE = 1.6  # texel of noise, in the level's smallest pixels
COARSER = 2.0  # second grain size over the first
SHARES = (0.8, 0.4)  # amplitudes of both sizes
SPARSE = 7.0  # texels of noise between averaged samples
BLOTCH_M = 0.6  # texel of the coarse noise
FINEST = 16  # most samples per texel of the raster
WARP = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


class Grain:
    """The grain of one level, placed in the world by a seed."""

    def __init__(self, level: Level, seed: int) -> None:
        longest = level.along_m * (ALONG if level.steep else (level.far_m / level.near_m) ** 2 / ROWS)
        sizes = (SIZE * level.across_m, COARSER * SIZE * level.across_m, BLOTCH_M)
        self._placed = [_placed(size, seed) for size in sizes]
        self._fineness = [min(FINEST, 2 ** max(0, ceil(log2(longest / (SPARSE * size))))) for size in sizes]

    def draw(self, raster: Raster) -> Image:
        """(rows, columns) about 128."""
        tile = grain_tile("ground", shortest=3.0, slope=0.2)
        fine, coarse = (self._averaged(raster, i, tile, raster.columns // 2 ** (i + 1)) for i in (0, 1))
        coarse = np.asarray(cv2.resize(coarse, fine.shape[::-1]), np.uint8)
        grain = cv2.addWeighted(fine, SHARES[0], coarse, SHARES[1], 128.0 * (1.0 - sum(SHARES)))
        return np.asarray(cv2.resize(grain, (raster.columns, raster.rows)), np.uint8)

    def blotches(self, raster: Raster) -> Image:
        """(rows, columns / 8) about 128: variation over metres."""
        tile = grain_tile("blotches", shortest=3.0, slope=1.0)
        return self._averaged(raster, 2, tile, raster.columns // 8)

    def _averaged(self, raster: Raster, index: int, tile: Image, columns: int) -> Image:
        """(rows, columns) one noise size, averaged along each texel."""
        fineness = self._fineness[index]
        size = (columns, fineness * raster.rows)
        matrix = self._placed[index] @ np.linalg.inv(raster.finer(columns / raster.columns, fineness))
        matrix = _shifted_to_tile(matrix, size)
        grain = cv2.warpPerspective(tile, matrix, size, flags=WARP, borderMode=cv2.BORDER_WRAP)
        while len(grain) > raster.rows:
            grain = cv2.addWeighted(grain[0::2], 0.5, grain[1::2], 0.5, 0.0)
        return np.asarray(grain, np.uint8)


def _placed(size_m: float, seed: int) -> Floats:
    """(3, 3) from world points to texels of noise of `size_m`."""
    rng = stream(seed, f"grain {size_m:.6g}")
    angle, (x, y) = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, TILE, 2)
    c, s = np.cos(angle) / size_m, np.sin(angle) / size_m
    return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])


def _shifted_to_tile(matrix: Floats, size: tuple[int, int]) -> Floats:
    """The mapping shifted by whole tiles, so that its middle falls in the middle of the doubled tile."""
    middle = matrix @ (0.5 * size[0], 0.5 * size[1], 1.0)
    whole = np.rint(middle[:2] / middle[2] / TILE) - 1.0
    return np.asarray(matrix - np.outer([*whole * TILE, 0.0], matrix[2]))
