"""Signals derived from others by physics. Axes: X forward, Y right, yaw clockwise."""

import numpy as np

from vpf_sim.geometry import unwrapped, vehicle_from_world
from vpf_sim.replay import series
from vpf_sim.replay.plausible import LIMITS
from vpf_sim.types import Bools, Floats, VehicleModel

LEAST_SPEED_MPS = 1.0  # below this a curvature is noise
SLOPE_WINDOW_S = 0.5  # for accelerations
PERIODS = (None, None, 2.0 * np.pi)  # of x, y, yaw
FASTEST_MPS = LIMITS["speed_mps"].highest
END_WINDOW_S = 1.0  # for the motion that continues at the ends


def slope(times_s: Floats, values: Floats, window_s: float = SLOPE_WINDOW_S) -> Floats:
    """(N,) derivative of values (N,) by a least-squares line over a window of at least three samples.

    For evenly spaced times this is the filter of Savitzky and Golay, Anal. Chem. 36, 1964, of degree 1. At the ends
    the slope of the line is extrapolated linearly to the time.
    """
    first = np.searchsorted(times_s, times_s - 0.5 * window_s - 1e-9)
    last = np.searchsorted(times_s, times_s + 0.5 * window_s + 1e-9)
    count, index = len(times_s), np.arange(len(times_s))
    first = np.maximum(np.minimum(first, np.minimum(index - 1, count - 3)), 0)
    last = np.minimum(np.maximum(last, np.maximum(index + 2, 3)), count)
    time = times_s - times_s.mean()
    sums = [np.concatenate([[0.0], np.cumsum(part)]) for part in (time, values, time * values, time * time)]
    t, v, tv, tt = (part[last] - part[first] for part in sums)
    n = last - first
    spread = n * tt - t * t
    lines: Floats = np.divide(n * tv - t * v, spread, out=np.zeros(count), where=spread > 0.0)
    result: Floats = lines + (time - t / n) * _change(t / n, lines)
    return result


def _change(times_s: Floats, values: Floats) -> Floats:
    """(N,) derivative by neighbouring values; 0 between equal times."""
    step = np.gradient(times_s) if len(times_s) > 1 else np.zeros(1)
    change = np.gradient(values) if len(values) > 1 else np.zeros(1)
    return np.asarray(np.divide(change, step, out=np.zeros_like(change), where=step > 1e-9))


def from_start(poses: Floats) -> Floats:
    """(N, 3) poses relative to the first."""
    relative = vehicle_from_world(poses[:, :2], poses[0])
    return np.column_stack([relative, poses[:, 2] - poses[0, 2]])


def poses_at(times_s: Floats, sampled_s: Floats, poses: Floats) -> Floats:
    """(N, 3) poses (M, 3) interpolated at other times; nan in gaps.

    Beyond the ends the motion continues for the length of a gap.
    """
    known = np.asarray(np.isfinite(poses).all(axis=1))
    parts = zip(np.where(known[:, None], poses, np.nan).T, PERIODS, strict=True)
    result = np.stack([series.at(times_s, sampled_s, part, period) for part, period in parts], axis=1)
    return _extrapolated(result, times_s, sampled_s[known], poses[known])


def bridged(times_s: Floats, poses: Floats) -> tuple[Floats, Bools]:
    """The poses (N, 3) with gaps interpolated, and which (N,) were gaps.

    At the ends the motion continues.
    """
    missing: Bools = np.asarray(~np.isfinite(poses).all(axis=1))
    if not missing.any() or missing.all():
        return poses, missing
    known_s, known = times_s[~missing], poses[~missing]
    parts = zip(np.where(missing[:, None], np.nan, poses).T, PERIODS, strict=True)
    result = np.stack([series.filled(times_s, part, period)[0] for part, period in parts], axis=1)
    return _extrapolated(result, times_s, known_s, known), missing


def _extrapolated(poses: Floats, times_s: Floats, known_s: Floats, known: Floats) -> Floats:
    """Poses (N, 3) that move on beyond the first and last known (M, 3)."""
    if len(known) < 2:
        return poses
    for axis in (0, 1):
        rates = np.clip(slope(known_s, known[:, axis], END_WINDOW_S), -FASTEST_MPS, FASTEST_MPS)
        for rate, beyond_s in (
            (rates[0], np.minimum(times_s - known_s[0], 0.0)),
            (rates[-1], np.maximum(times_s - known_s[-1], 0.0)),
        ):
            poses[:, axis] += rate * beyond_s
    return poses


def speed(times_s: Floats, poses: Floats) -> Floats:
    """(N,) m/s from poses (N, 3)."""
    velocity = np.gradient(poses[:, :2], times_s, axis=0)
    return np.asarray(np.hypot(velocity[:, 0], velocity[:, 1]))


def yaw_rate(times_s: Floats, poses: Floats) -> Floats:
    """(N,) rad/s, + right, from poses (N, 3)."""
    return np.asarray(np.gradient(unwrapped(poses[:, 2]), times_s))


def travelled(times_s: Floats, speed_mps: Floats, yaw_rate_radps: Floats, ahead_m: float = 0.0) -> Floats:
    """(N, 3) camera poses by dead reckoning from the origin along X.

    The rear axle moves along the heading; the camera is `ahead_m` before it.
    """
    step_s = np.diff(times_s)
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (yaw_rate_radps[1:] + yaw_rate_radps[:-1]) * step_s)])
    step_m = 0.5 * (speed_mps[1:] + speed_mps[:-1]) * step_s
    middle = 0.5 * (turned[1:] + turned[:-1])
    axle = [np.concatenate([[0.0], np.cumsum(step_m * part)]) for part in (np.cos(middle), np.sin(middle))]
    camera = [axle[0] + ahead_m * (np.cos(turned) - 1.0), axle[1] + ahead_m * np.sin(turned)]
    return np.stack([*camera, turned], axis=1)


def steering(speed_mps: Floats, yaw_rate_radps: Floats, wheelbase_m: float) -> Floats:
    """(N,) rad, + right: tan(steering) = wheelbase x yaw rate / speed, the kinematic bicycle; nan below 1 m/s."""
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.arctan(wheelbase_m * yaw_rate_radps / speed_mps)
    return np.where(speed_mps >= LEAST_SPEED_MPS, angle, np.nan)


def throttle(acceleration_mps2: Floats, vehicle: VehicleModel | None = None) -> Floats:
    """(N,) -1 .. 1: acceleration over the full scale of the throttle or, below zero, of the brake."""
    car = vehicle or VehicleModel()
    full = np.where(acceleration_mps2 >= 0.0, car.full_throttle_mps2, car.full_brake_mps2)
    return np.asarray(np.clip(acceleration_mps2 / full, -1.0, 1.0))
