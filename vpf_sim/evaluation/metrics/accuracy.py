"""The paper's accuracy of throttle and steering against the PID, by three definitions.

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
