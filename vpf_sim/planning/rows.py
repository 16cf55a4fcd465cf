"""Rows of bodies: a gap between two of them is worth less the narrower it is.

Whoever put two bodies in a row across the road may have put a third between them. What is low is told last, in rain no
sooner than the car needs to get to the other side of the row.
"""

import numpy as np

from vpf_sim.planning.lane import LaneObstacles
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
    bodies: LaneObstacles, in_row: Bools, weight: Floats, y_m: Floats, widths_m: tuple[float, float]
) -> Floats:
    """(G,) 0 .. 1 at places across the road: how far the gap there, between two bodies of a row, falls short of wide,
    the second of the widths; times the lesser of the weights (K,) of both. 0 elsewhere, and where it is narrower than
    the first: that is no gap to be gone through. `in_row` (K, K) tells who is in one row with whom.
    """
    least_m, wide_m = widths_m
    narrow = np.zeros_like(y_m)
    if np.count_nonzero(weight) < 2:
        return narrow
    gap = bodies.left_m[None] - bodies.right_m[:, None]  # (K, K) from each body to each
    for left, right in zip(*((gap > least_m) & (gap < wide_m) & in_row).nonzero(), strict=True):
        between = (y_m > bodies.right_m[left]) & (y_m < bodies.left_m[right])
        short = (1.0 - gap[left, right] / wide_m) * min(weight[left], weight[right])
        narrow = np.maximum(narrow, between * short)
    return narrow
