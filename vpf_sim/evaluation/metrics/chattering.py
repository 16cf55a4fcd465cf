"""Chattering of the commands, the known weakness of sliding mode control.

For a signal u_k, k = 1 .. n, commanded over T seconds in [-1, 1], with d_k = u_k+1 - u_k:

    direction_changes_per_s   sign changes of d / T; pauses and steps of rounding size do not count
    total_variation_per_s     sum |d| / T, 1/s

and the rate |d| / dt, rad/s, of the commanded steering angle, u times the limit of 40 degrees.
"""

import numpy as np

from vpf_sim.evaluation.steps import StepTable
from vpf_sim.types import Floats, VehicleModel

ROUNDING = 1e-6
SIGNALS = ("throttle", "steering")


def chattering(table: StepTable) -> dict[str, object] | None:
    """Both signals' direction changes and total variation, and the steering rate's 95th percentile and maximum.

    None for fewer than two commands.
    """
    time_s = table.time_s[: len(table)]
    if len(time_s) < 2:
        return None
    signals = {name: getattr(table, name)[: len(table)] for name in SIGNALS}
    duration_s = float(time_s[-1] - time_s[0])
    rates = np.abs(np.diff(signals["steering"])) / np.diff(time_s) * VehicleModel().steering_limit_rad
    return {
        **{
            name: {
                "direction_changes_per_s": direction_changes(signal) / duration_s,
                "total_variation_per_s": float(np.sum(np.abs(np.diff(signal)))) / duration_s,
            }
            for name, signal in signals.items()
        },
        "steering_rate_radps": {"p95": float(np.percentile(rates, 95.0)), "max": float(np.max(rates))},
    }


def direction_changes(signal: Floats) -> int:
    """How often an (n,) signal changes between rising and falling."""
    steps = np.diff(signal)
    directions = np.sign(steps[np.abs(steps) > ROUNDING])
    return int(np.count_nonzero(np.diff(directions)))
