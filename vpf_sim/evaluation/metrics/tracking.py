"""How closely a drive follows its references: the lane's centre, and the PID's commands.

The paper's accuracy of throttle and steering against the PID, by three definitions.

The paper gives no formula for its "prediction accuracy (%) with respect to PID", and no single definition yields its
pairs of numbers. Each is a share (1 is best), for a signal u and the PID's w, d = u - w:

    range      1 - mean |d| / 2                   2 is the width of the command range [-1, 1]
    span       1 - mean |d| / (max w - min w)     the range that the PID used in the whole episode
    tolerance  share of samples with |d| <= 0.1
    mae        mean |d|

Protocols. shadow: the PID's command at every state that the driver visited. paired: the PID's own run without
obstacles, matched by distance along the route.
"""

import numpy as np

from vpf_sim.types import Bools, Floats

TOLERANCE = 0.1
Accuracy = dict[str, float | None]


def accuracy(signal: Floats, pid: Floats, span: float) -> Accuracy | None:
    """The definitions for (N,) samples, None without samples; "span" is None for a span of 0."""
    if len(signal) == 0:
        return None
    difference = np.abs(signal - pid)
    mae = float(np.mean(difference))
    return {
        "range": 1.0 - mae / 2.0,
        "span": 1.0 - mae / span if span > 0.0 else None,
        "tolerance": float(np.mean(difference <= TOLERANCE)),
        "mae": mae,
    }


def protocol(commands: dict[str, Floats], pid: dict[str, Floats], passing: Bools) -> dict[str, object]:
    """Accuracy of each signal over the whole route, and in two parts: clear of obstacles, and passing one."""
    parts = {"whole": np.ones_like(passing), "clear_of_obstacles": ~passing, "passing": passing}
    by_part = {
        part: {name: accuracy(commands[name][mask], pid[name][mask], _span(pid[name])) for name in commands}
        for part, mask in parts.items()
    }
    whole = by_part.pop("whole")
    return {**whole, **by_part}


def at_distance(route_m: Floats, own_route_m: Floats, own_signal: Floats) -> Floats:
    """(N,) the PID's signal at the distances `route_m` of its own run, interpolated; the ends are held.

    While the PID's run stands still, its first frame counts.
    """
    furthest = np.maximum.accumulate(own_route_m)
    first = np.concatenate([[True], np.diff(furthest) > 0.0])
    matched: Floats = np.interp(route_m, furthest[first], own_signal[first])
    return matched


def _span(signal: Floats) -> float:
    return float(np.ptp(signal)) if len(signal) else 0.0


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
