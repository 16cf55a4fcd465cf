"""Checks that the signals of a recording agree with each other; contradictions become notes."""

from collections.abc import Iterator, Mapping
from itertools import combinations

import numpy as np

from vpf_sim.geometry import wrap_angles
from vpf_sim.replay import derived, paths
from vpf_sim.types import Bools, Floats

WINDOW_S = 1.0  # window for speed and course from positions
MOVING_MPS, FAR_M = 2.0, 20.0  # least speed for a course; least distance for a speed check
SPEED_RATIO = 1.33  # largest ratio of two consistent speeds
UNITS = {3.6: "km/h", 2.237: "mph", 1.0 / 3.6: "m/s, labelled as km/h", 0.447: "m/s, labelled as mph"}
MOST_ACCELERATION_MPS2, MOST_SHARE = 12.0, 0.05  # tyre limit; share of frames that counts as a contradiction
MOST_HEADING_ERROR_RAD = 0.35  # largest consistent difference of heading and course
TURNING_RADPS, OPPOSITE, ALIKE, GAIN = 0.02, -0.5, 0.8, 3.0


def contradictions(
    times_s: Floats, signals: Mapping[str, Floats], recorded: frozenset[str], wheelbase_m: float
) -> Iterator[str]:
    """One line for each contradiction.

    `recorded` names the recorded signals; it contains "heading" if poses have a measured heading.
    """
    poses = signals["poses"] if "poses" in recorded else None
    speed = signals["speed_mps"]
    if poses is not None:
        velocity = np.stack([derived.slope(times_s, part, WINDOW_S) for part in poses[:, :2].T], axis=1)
        ground_speed = np.hypot(velocity[:, 0], velocity[:, 1])
        course = paths.course(times_s, poses[:, :2])
        if "speed_mps" in recorded:
            yield from _speeds(times_s, np.abs(speed), ground_speed)
        if "heading" in recorded:
            yield from _heading(poses[:, 2], course, ground_speed > MOVING_MPS)
    yield from _tyres(times_s, signals, recorded)
    rates = dict(_turns(times_s, signals, recorded, wheelbase_m))
    moving = np.abs(speed) > MOVING_MPS
    if poses is not None:
        moving &= ground_speed > MOVING_MPS
        rates["the course"] = derived.slope(times_s, course, WINDOW_S)
    for (one, first), (other, second) in combinations(rates.items(), 2):
        yield from _opposed(one, first[moving], other, second[moving])


def _speeds(times_s: Floats, speed: Floats, ground_speed: Floats) -> Iterator[str]:
    along, driven = (float(np.trapezoid(part, times_s)) for part in (speed, ground_speed))
    if max(along, driven) < FAR_M:
        return
    ratio = along / max(driven, 1e-9)
    if 1.0 / SPEED_RATIO <= ratio <= SPEED_RATIO:
        return
    unit = next((f": {name}?" for factor, name in UNITS.items() if abs(ratio / factor - 1.0) < 0.1), "")
    yield f"speed and positions disagree: {along:.0f} m by the speed, {driven:.0f} m by the positions{unit}"


def _heading(heading: Floats, course: Floats, moving: Bools) -> Iterator[str]:
    if not moving.any():
        return
    off = float(np.median(np.abs(wrap_angles(heading - course)[moving])))
    if off > MOST_HEADING_ERROR_RAD:
        yield f"the heading is {np.degrees(off):.0f} deg off the course (median): wrong zero, sign or unit?"


def _tyres(times_s: Floats, signals: Mapping[str, Floats], recorded: frozenset[str]) -> Iterator[str]:
    speed = signals["speed_mps"]
    if "speed_mps" not in recorded:
        return
    found = {"the speed's changes need": derived.slope(times_s, speed)}
    if "yaw_rate_radps" in recorded or "heading" in recorded:
        found["speed and yaw rate need"] = speed * signals["yaw_rate_radps"]
    for name, values in found.items():
        share = float(np.mean(np.abs(values) > MOST_ACCELERATION_MPS2))
        if share > MOST_SHARE:
            worst = float(np.abs(values).max())
            often = f"over {MOST_ACCELERATION_MPS2:g} in {share:.0%} of frames"
            yield f"{name} up to {worst:.0f} m/s2, {often}: a wrong unit?"


def _turns(
    times_s: Floats, signals: Mapping[str, Floats], recorded: frozenset[str], wheelbase_m: float
) -> Iterator[tuple[str, Floats]]:
    """Yaw rates (N,), rad/s, one for each signal that yields one."""
    if "yaw_rate_radps" in recorded:
        yield "the yaw rate", signals["yaw_rate_radps"]
    if "heading" in recorded:
        yield "the heading", derived.yaw_rate(times_s, signals["poses"])
    if "steering_rad" in recorded:
        yield "the steering", signals["speed_mps"] * np.tan(signals["steering_rad"]) / wheelbase_m


def _opposed(one: str, first: Floats, other: str, second: Floats) -> Iterator[str]:
    both = np.isfinite(first) & np.isfinite(second)
    if np.count_nonzero(both) < 10:
        return
    first, second = first[both], second[both]
    size, likewise = (float(np.sqrt(np.mean(part**2))) for part in (first, second))
    if min(size, likewise) < TURNING_RADPS:
        return
    alike = float(np.mean(first * second)) / (size * likewise)
    if alike < OPPOSITE:
        yield f"{one} and {other} turn opposite ways (correlation {alike:.2f}): a sign, or latitude and longitude?"
    elif alike > ALIKE and not 1.0 / GAIN < size / likewise < GAIN:
        yield f"{one} turns {size / likewise:.3g} times as fast as {other}: a wrong unit?"
