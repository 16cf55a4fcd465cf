"""Grids of the patch of road: their type, and what OpenCV computes on them."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Image

Grid = NDArray[np.float32]


def least_of(grids: list[Grid]) -> Grid:
    """(rows, columns) the least of all grids, by OpenCV: numpy checks for nan, and takes longer."""
    least, *others = grids
    for grid in others:
        least = np.asarray(cv2.min(least, grid), np.float32)
    return least


def share_of(free: Image, window: tuple[int, int], least: float) -> Grid:
    """(rows, columns) share of the cells about each, in a window (columns, rows), that are 1; `least` at least.

    It is `cv2.blur` of them as floats, to the bit: they are fewer than 256, so that bytes count them faster.
    """
    count = cv2.boxFilter(free, -1, window, normalize=False)
    return np.asarray(cv2.LUT(count, _shares(window[0] * window[1], least)), np.float32)


@lru_cache(maxsize=8)
def _shares(cells: int, least: float) -> Grid:
    """(256,) share that a number of cells is of so many."""
    shares: Grid = np.maximum(np.arange(256) * (1.0 / cells), least).astype(np.float32)
    return shares
