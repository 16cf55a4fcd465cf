"""Path tracking error and route completion."""

import numpy as np

from vpf_sim.types import Floats


def path_mse(positions_m: Floats, path_m: Floats) -> float | None:
    """Mean squared distance from (N, 2) positions to the nearest point of the polyline (M, 2), m2.

        MSE = 1/n sum |p_i - q(p_i)|^2,  q(p) the nearest point of the path

    The paper's MSE_XY (its brackets are missing, its unit is printed as m). The nearest point is used
    because the point at the same time would measure the lag along the road.
    """
    if len(positions_m) == 0:
        return None
    return float(np.mean(distances(positions_m, path_m) ** 2))


def distances(positions_m: Floats, path_m: Floats) -> Floats:
    """(N,) m, from each position to the nearest point of the polyline."""
    start, along = path_m[:-1], np.diff(path_m, axis=0)
    squared_length = np.maximum(np.sum(along**2, axis=1), 1e-12)
    nearest = np.empty(len(positions_m))
    for block in np.array_split(np.arange(len(positions_m)), 1 + len(positions_m) // 256):  # bounds the memory
        away = positions_m[block, None] - start
        share = np.clip(np.sum(away * along, axis=2) / squared_length, 0.0, 1.0)
        nearest[block] = np.sqrt(np.min(np.sum((away - share[..., None] * along) ** 2, axis=2), axis=1))
    return nearest


def shorten(path_m: Floats, length_m: float) -> Floats:
    """The first `length_m` of a polyline (M, 2)."""
    reached = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path_m, axis=0).T))])
    if length_m >= reached[-1]:
        return path_m
    end = [np.interp(length_m, reached, path_m[:, axis]) for axis in (0, 1)]
    return np.vstack([path_m[reached < length_m], end])


def completion(route_m: Floats, length_m: float) -> float:
    """Share of the route that was driven, 0 to 1: furthest position / length, both m along the route."""
    if len(route_m) == 0:
        return 0.0
    return float(np.clip(np.max(route_m) / length_m, 0.0, 1.0))
