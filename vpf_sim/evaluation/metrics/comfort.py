"""Comfort as nuPlan computes it, and percentiles of the unfiltered signals.

Source: nuplan-devkit, planning/metrics/utils/state_extractors.py and evaluation_metrics/common/ego_*.py: states at
10 Hz; accelerations smoothed by Savitzky-Golay (window 8, order 2); jerks as its derivative of those (window 15, order
2); yaw rate and yaw acceleration as derivatives of the unwrapped heading (window 5; order 2 and 3).

Chattering of the commands, the known weakness of sliding mode control.

For a signal u_k, k = 1 .. n, commanded over T seconds in [-1, 1], with d_k = u_k+1 - u_k:

    direction_changes_per_s   sign changes of d / T; pauses and steps of rounding size do not count
    total_variation_per_s     sum |d| / T, 1/s

and the rate |d| / dt, rad/s, of the commanded steering angle, u times the limit of 40 degrees.
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.polynomial import polynomial

from vpf_sim.evaluation.metrics.collision import min_ttc_s
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.geometry import unwrapped
from vpf_sim.types import Floats, VehicleModel

RATE_HZ = 10.0
ACCELERATION_WINDOW = 8
JERK_WINDOW = 15
HEADING_WINDOW = 5
TTC_BOUND_S = 0.95
ROUNDING = 1e-6
SIGNALS = ("throttle", "steering")


class Bound(NamedTuple):
    low: float
    high: float


BOUNDS = {
    "longitudinal_acceleration_mps2": Bound(-4.05, 2.40),
    "lateral_acceleration_mps2": Bound(-4.89, 4.89),
    "jerk_mps3": Bound(-8.37, 8.37),
    "longitudinal_jerk_mps3": Bound(-4.13, 4.13),
    "yaw_rate_radps": Bound(-0.95, 0.95),
    "yaw_acceleration_radps2": Bound(-1.93, 1.93),
}


def comfort(table: StepTable) -> dict[str, object]:
    """Minimum, maximum and bound check of each signal, least TTC, and whether all bounds hold."""
    signals = nuplan_signals(table.time_s, table.speed_mps, table.yaw_rad, table.yaw_rate_radps)
    if signals is None:
        return {"comfortable": None, "signals": None, "min_ttc_s": None, "ttc_within": None, "raw_p95": None}
    checked = {name: _against_bound(signals[name], bound) for name, bound in BOUNDS.items()}
    ttc_s = min_ttc_s(table.ttc_s)
    far = ttc_s is None or ttc_s >= TTC_BOUND_S
    return {
        "comfortable": far and all(row["within"] for row in checked.values()),
        "signals": checked,
        "min_ttc_s": ttc_s,
        "ttc_within": far,
        "raw_p95": raw_percentiles(table),
    }


def nuplan_signals(
    time_s: Floats, speed_mps: Floats, yaw_rad: Floats, yaw_rate_radps: Floats
) -> dict[str, Floats] | None:
    """The signals of BOUNDS at 10 Hz from (N,) states; None for fewer than the filters need (0.5 s)."""
    duration_s = time_s[-1] - time_s[0] if len(time_s) else 0.0
    samples = int(np.floor(duration_s * RATE_HZ + 1e-6)) + 1
    if samples <= HEADING_WINDOW:
        return None
    at = time_s[0] + np.arange(samples) / RATE_HZ
    yaw = np.interp(at, time_s, unwrapped(yaw_rad))
    along = np.interp(at, time_s, np.gradient(speed_mps, time_s))
    across = np.interp(at, time_s, speed_mps * yaw_rate_radps)
    accelerations = {"x": along, "y": across, "xy": np.hypot(along, across)}
    smooth = {name: _fitted(signal, ACCELERATION_WINDOW, order=2) for name, signal in accelerations.items()}
    return {
        "longitudinal_acceleration_mps2": smooth["x"],
        "lateral_acceleration_mps2": smooth["y"],
        "jerk_mps3": _fitted(smooth["xy"], JERK_WINDOW, order=2, times=1),
        "longitudinal_jerk_mps3": _fitted(smooth["x"], JERK_WINDOW, order=2, times=1),
        "yaw_rate_radps": _fitted(yaw, HEADING_WINDOW, order=2, times=1),
        "yaw_acceleration_radps2": _fitted(yaw, HEADING_WINDOW, order=3, times=2),
    }


def raw_percentiles(table: StepTable) -> dict[str, float]:
    """95th percentiles of the absolute unfiltered signals at the full rate; steering in commands a second."""
    dt_s = np.diff(table.time_s)
    acceleration = np.diff(table.speed_mps) / dt_s
    signals = {
        "longitudinal_acceleration_mps2": acceleration,
        "lateral_acceleration_mps2": table.speed_mps * table.yaw_rate_radps,
        "longitudinal_jerk_mps3": np.diff(acceleration) / dt_s[1:],
        "yaw_acceleration_radps2": np.diff(table.yaw_rate_radps) / dt_s,
        "steering_rate_per_s": np.diff(table.steering[:-1]) / dt_s[:-1],
    }
    return {name: float(np.percentile(np.abs(signal), 95.0)) for name, signal in signals.items()}


def _fitted(signal: Floats, window: int, order: int, times: int = 0) -> Floats:
    """(N,) signal after the filter of Savitzky and Golay, derived `times`: polynomials fitted to `window` samples.

    As scipy.signal.savgol_filter, whose import takes a quarter of the time in which a drive begins: at the middle of
    each window, and at the samples themselves in the first and last half window.
    """
    window = min(window, len(signal))
    half, samples = window // 2, np.arange(len(signal))
    first = np.clip(samples - (window - 1) // 2, 0, len(signal) - window)
    inside = (samples >= half) & (samples < len(signal) - half)
    at = np.where(inside, 0.5 * (window - 1), samples - first)
    fit = np.linalg.pinv(polynomial.polyvander(np.arange(window), order))
    coefficients = np.einsum("pw,nw->pn", fit, sliding_window_view(signal, window)[first])
    fitted: Floats = np.asarray(polynomial.polyval(at, polynomial.polyder(coefficients, times), tensor=False))
    return fitted * RATE_HZ**times


def _against_bound(signal: Floats, bound: Bound) -> dict[str, float | bool]:
    low, high = float(np.min(signal)), float(np.max(signal))
    return {"min": low, "max": high, "within": bound.low <= low and high <= bound.high}


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
