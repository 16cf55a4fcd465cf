"""Which points belong together."""

from collections.abc import Callable

import numpy as np
from scipy.sparse.csgraph import connected_components

from vpf_sim.types import Bools, Floats, Integers


def clusters(place_m: Floats, sigma_m: Floats, right_m: float, forward_m: float, sigmas: float) -> Integers:
    """(M,) cluster of each of M points, near ones together."""
    gap = np.abs(place_m[:, None] - place_m[None])
    reach = np.maximum(forward_m, sigmas * np.hypot(sigma_m[:, None], sigma_m[None]))
    near = (gap[..., 1] < right_m) & (gap[..., 0] < reach)
    return np.asarray(connected_components(near)[1], np.int64)


def split(label: Integers, group: Integers, are_obstacles: Callable[[Integers], Bools]) -> tuple[Integers, Bools]:
    """Labels (M,) with groups of points split off their clusters, and which of the clusters (K,) are such.

    `group` (M,) is -1 for all other points. One is split off only if it and the rest both are obstacles of several
    points: else an obstacle would lose a side.
    """
    count = int(label.max()) + 1
    parts = np.unique(label + count * (group + 1), return_inverse=True)[1]
    several = (are_obstacles(parts) & (np.bincount(parts) > 1))[parts]
    remains = np.isin(label, label[several & (group < 0)])
    names, parts = np.unique(label + count * np.where(several & remains, group + 1, 0), return_inverse=True)
    return parts.astype(np.int64), names >= count
