"""Rows of bodies: a gap between two of them is worth less the narrower it is.

Whoever put two bodies in a row across the road may have put a third between them. What is low is told last, in rain no
sooner than the car needs to get to the other side of the row.
"""

import numpy as np

from vpf_sim.planning.lane import LaneObstacles
from vpf_sim.types import Floats

ROW_M = 5.0  # what stands so far behind another is of its row


def narrowness(obstacles: LaneObstacles, weight: Floats, y_m: Floats, widths_m: tuple[float, float]) -> Floats:
    """(G,) 0 .. 1 at places across the road: how far the gap there, between two bodies of a row, falls short of wide,
    the second of the widths; times the lesser of the weights (K,) of both. 0 elsewhere, and where it is narrower than
    the first: that is no gap to be gone through.
    """
    least_m, wide_m = widths_m
    narrow = np.zeros_like(y_m)
    if np.count_nonzero(weight) < 2:
        return narrow
    row, weight = obstacles.chosen(weight > 0.0), weight[weight > 0.0]
    gap = row.left_m[None] - row.right_m[:, None]  # (R, R) from each body to each
    beside = (gap > least_m) & (gap < wide_m) & (np.abs(row.along_m[None] - row.along_m[:, None]) < ROW_M)
    for left, right in np.argwhere(beside):
        between = (y_m > row.right_m[left]) & (y_m < row.left_m[right])
        short = (1.0 - gap[left, right] / wide_m) * min(weight[left], weight[right])
        narrow = np.maximum(narrow, between * short)
    return narrow
