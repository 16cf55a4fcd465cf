"""Obstacles by their places."""

from collections.abc import Sequence

import numpy as np

from vpf_sim.types import Obstacles


def obstacles(
    *places_m: tuple[float, float, float],
    sigma_m: float = 0.2,
    identity: Sequence[int] | None = None,
    speed_mps: Sequence[float] = (),
) -> Obstacles:
    """By face ahead, left and right side; numbered from 0, and standing, if nothing else is said."""
    forward, left, right = np.array(places_m, float).reshape(-1, 3).T
    same, names = np.ones(len(forward)), np.arange(len(forward)) if identity is None else np.array(identity)
    return Obstacles(forward, left, right, sigma_m * same, np.inf * same, names, np.array(speed_mps, float))
