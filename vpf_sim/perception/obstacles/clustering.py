"""Which points belong together."""

from collections.abc import Callable

import numpy as np

from vpf_sim.perception.obstacles.point_hypotheses import Integers
from vpf_sim.types import Bools, Floats


def clusters(place_m: Floats, sigma_m: Floats, right_m: float, forward_m: float) -> Integers:
    """(M,) the body that each of M points belongs to, those near each other to one."""
    gap = np.abs(place_m[:, None] - place_m[None])
    reach = np.maximum(forward_m, 2.5 * np.hypot(sigma_m[:, None], sigma_m[None]))
    return connected((gap[..., 1] < right_m) & (gap[..., 0] < reach))


def stepped(label: Integers, behind: Integers, are_bodies: Callable[[Integers], Bools]) -> tuple[Integers, Bools]:
    """The label (M,) with the points `behind` a cluster taken out of it, and which of the clusters (K,) are such.

    `behind` (M,) numbers the clusters that those make among themselves, -1 for all others. One is taken out only where
    it and what remains both are bodies, of several points: else a side of a body would be lost.
    """
    count = int(label.max()) + 1
    parts = np.unique(label + count * (behind + 1), return_inverse=True)[1]
    several = (are_bodies(parts) & (np.bincount(parts) > 1))[parts]
    remains = np.isin(label, label[several & (behind < 0)])
    names, parts = np.unique(label + count * np.where(several & remains, behind + 1, 0), return_inverse=True)
    return parts.astype(np.int64), names >= count


def connected(linked: Bools) -> Integers:
    """(N,) which connected part each node of a symmetric graph (N, N) belongs to, counted from 0."""
    label = np.arange(len(linked))
    while True:
        least = np.minimum(np.where(linked, label, len(label)).min(axis=1), label)
        least = least[least]  # of the least of its part: long chains close soon
        if np.array_equal(least, label):
            return np.unique(label, return_inverse=True)[1].astype(np.int64)
        label = least
