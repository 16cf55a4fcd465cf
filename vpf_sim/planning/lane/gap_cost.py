"""Cost of gaps in a row of obstacles, between two of them or one and an edge: the narrower, the higher.

In a row there may be one more obstacle. A low one is detected last, in rain hardly before the car must turn aside.
"""

import numpy as np

from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.types import Bools, Floats


def narrowness(
    obstacles: LaneObstacles, in_row: Bools, weight: Floats, lane: Lane, y_m: Floats, widths_m: tuple[float, float]
) -> Floats:
    """(G,) 0 .. 1 at places across the road: how far the gap there falls short of the second width.

    It is times the lesser of the weights (K,) of both sides, 0 elsewhere and in gaps below the first width, which no
    car enters. `in_row` (K, K): which obstacles are in one row.
    """
    least_m, wide_m = widths_m
    narrow = np.zeros_like(y_m)
    if not weight.any():
        return narrow
    alone = np.diag(in_row)
    begins, ends = np.append(obstacles.right_m, lane.left_m), np.append(obstacles.left_m, lane.right_m)  # of gaps
    pairs = np.block([[in_row, alone[:, None]], [alone[None], np.zeros((1, 1), np.bool_)]])
    weights = np.append(weight, 1.0)
    gap = ends[None] - begins[:, None]  # (K + 1, K + 1) from each obstacle, or the left edge, to each, or the right one
    for left, right in zip(*((gap > least_m) & (gap < wide_m) & pairs).nonzero(), strict=True):
        between = (y_m > begins[left]) & (y_m < ends[right])
        short = (1.0 - gap[left, right] / wide_m) * min(weights[left], weights[right])
        narrow = np.maximum(narrow, between * short)
    return narrow
