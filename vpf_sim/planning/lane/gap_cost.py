"""Rows of bodies: a gap between two of them, or between one and the road's edge, is worth less the narrower it is.

Whoever put bodies in a row across the road may have put one more beside them. What is low is told last, in rain no
sooner than the car needs to get to the other side of the row.
"""

import numpy as np

from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.types import Bools, Floats

ROW_M = 5.0  # what stands so far behind the first that is in our way is met with it
BEYOND_M = 1.5  # what stands no farther behind where another may end is of its row


def same_row(bodies: LaneObstacles, length_m: Floats) -> Bools:
    """(K, K) which bodies stand in one row, wherever across the road; they are as long as (K,) at least.

    Faces are as far apart as the bodies are long: of a truck and of who stands beside its middle.
    """
    if len(bodies) < 2:
        return np.ones((len(bodies), len(bodies)), np.bool_)
    behind, reach = bodies.along_m[None] - bodies.along_m[:, None], length_m + BEYOND_M
    row: Bools = np.where(behind > 0.0, behind < reach[:, None], -behind < reach[None])
    return row


def narrowness(
    bodies: LaneObstacles, in_row: Bools, weight: Floats, lane: Lane, y_m: Floats, widths_m: tuple[float, float]
) -> Floats:
    """(G,) 0 .. 1 at places across the road: how far the gap there, between two bodies of a row or one and an edge,
    falls short of wide, the second of the widths; times the lesser of the weights (K,) of both. 0 elsewhere, and where
    it is narrower than the first: that is no gap to be gone through. `in_row` (K, K) tells who is in one row with whom.
    """
    least_m, wide_m = widths_m
    narrow = np.zeros_like(y_m)
    if not weight.any():
        return narrow
    alone = np.diag(in_row)  # each is in its own row, unless it moves or has been passed
    begins, ends = np.append(bodies.right_m, lane.left_m), np.append(bodies.left_m, lane.right_m)  # of gaps
    pairs = np.block([[in_row, alone[:, None]], [alone[None], np.zeros((1, 1), np.bool_)]])
    weights = np.append(weight, 1.0)
    gap = ends[None] - begins[:, None]  # (K + 1, K + 1) from each body, or the left edge, to each, or the right one
    for left, right in zip(*((gap > least_m) & (gap < wide_m) & pairs).nonzero(), strict=True):
        between = (y_m > begins[left]) & (y_m < ends[right])
        short = (1.0 - gap[left, right] / wide_m) * min(weights[left], weights[right])
        narrow = np.maximum(narrow, between * short)
    return narrow
