"""How clear a corner the window of a followed point holds. Along an edge Lucas-Kanade slides; on a corner it can't."""

import numpy as np

from vpf_sim.types import Bools, Floats


def eigenvalues(structure: Floats) -> tuple[Floats, Floats]:
    """(N,) small and (N,) large ones, grey levels^2 / px^2, of symmetric structure tensors (N, 2, 2).

    Shi and Tomasi (1994), doi 10.1109/CVPR.1994.323794.
    """
    a, b, d = structure[:, 0, 0], structure[:, 0, 1], structure[:, 1, 1]
    mean, half = 0.5 * (a + d), np.hypot(0.5 * (a - d), b)
    return mean - half, mean + half


def is_corner(structure: Floats, least: float, ratio: float) -> Bools:
    """(N,) tensors (N, 2, 2) with a small eigenvalue above `least` that is no less than that share of the large one."""
    small, large = eigenvalues(structure)
    clear: Bools = (small > least) & (small > ratio * large)
    return clear
