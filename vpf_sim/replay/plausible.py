"""Limits of every recorded value, and how values outside them are handled.

A few impossible values are logger faults: they become gaps with a note. Many mean that a column is something else
than its name says, usually in another unit: that is an InputError. `consistency` compares signals with each other.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from vpf_sim.errors import InputError
from vpf_sim.types import Bools, Floats, Image


@dataclass(frozen=True, slots=True)
class Limit:
    """Range of a value, and the likely cause of one outside it."""

    lowest: float
    highest: float
    hint: str = ""


LIMITS = {
    # Signals, in our units.
    "speed_mps": Limit(-20.0, 100.0, "another unit?"),
    "velocity_mps": Limit(-100.0, 100.0, "another unit?"),  # north or east
    "yaw_rate_radps": Limit(-3.0, 3.0, "degrees?"),
    "steering_rad": Limit(-1.4, 1.4, "degrees, or the angle of the steering wheel?"),
    "throttle": Limit(-1.0, 1.0, "percent?"),
    "pedal": Limit(-0.05, 1.05, "percent?"),
    "acceleration_mps2": Limit(-20.0, 20.0, "another unit?"),
    "yaw_rad": Limit(-130.0, 130.0, "degrees?"),
    "x_m": Limit(-1e8, 1e8),
    "y_m": Limit(-1e8, 1e8),
    "altitude_m": Limit(-1000.0, 10000.0),
    "latitude_deg": Limit(-85.0, 85.0, "the longitude?"),
    "longitude_deg": Limit(-360.0, 360.0),
    "obstacle": Limit(0.0, 1.0),
    "lead_gap_m": Limit(-5.0, 1000.0),
    "clock_s": Limit(-1e11, 1e11, "milliseconds or less?"),  # also since 1970
    # Keys of drive.toml.
    "rate_hz": Limit(0.2, 1000.0),
    "speed_mps_held": Limit(0.0, 100.0, "another unit?"),
    "focal_px": Limit(10.0, 1e5, "millimetres?"),
    "centre_px": Limit(-1e5, 1e5),
    "field_of_view_deg": Limit(10.0, 170.0, "rad?"),
    "distortion": Limit(-1e3, 1e3),
    "height_m": Limit(0.1, 10.0, "another unit?"),
    "pitch_deg": Limit(-60.0, 60.0),
    "yaw_deg": Limit(-60.0, 60.0),
    "roll_deg": Limit(-60.0, 60.0),
    "ahead_of_rear_axle_m": Limit(-20.0, 20.0, "another unit?"),
    "wheelbase_m": Limit(0.5, 20.0, "another unit?"),
    "steering_ratio": Limit(1.0, 100.0),
    "offset_s": Limit(-1e11, 1e11),
}
MANY = 0.2  # share of impossible values, above which the column is wrong
JUMP_M = 20.0  # allowed correction of a receiver
FRAME_INTERVAL_S, SELDOM_S = Limit(1e-3, 5.0), 0.5  # of the median; flow cannot be tracked over more
LONGEST_S = 1e6  # of a drive
CLOCKS = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds"}
DARK, BRIGHT, BLANK = 24, 231, 4  # grey levels of black, white and uniform images
PARTS = (1.0, 99.0)  # percentiles


@dataclass(frozen=True, slots=True)
class Location:
    """How messages name a sequence of values and the position of each."""

    source: str  # path of the file
    column: str
    positions: Sequence[int] | None = None  # in the file; None: from 0
    unit: str = "row"  # of the positions

    def at(self, index: int) -> str:
        return f"{self.unit} {index if self.positions is None else self.positions[index]}"

    def __str__(self) -> str:
        return f"{self.source.rsplit('/', 1)[-1]}: {self.column}"


def within_limits(
    values: Floats, signal: str, where: Location, notes: list[str], scale: float = 1.0, refuses: bool = True
) -> Floats:
    """(N,) values, nan where impossible; `scale` converts their unit to that of the limits.

    Raises InputError if many are impossible and `refuses` is set.
    """
    limit = LIMITS[signal]
    lowest, highest = limit.lowest / abs(scale), limit.highest / abs(scale)
    known = ~np.isnan(values)
    impossible = known & ~((values >= lowest - 1e-9) & (values <= highest + 1e-9))
    if not impossible.any():
        return values
    first, count = int(np.argmax(impossible)), int(np.count_nonzero(impossible))
    expected = f"{lowest:.6g} to {highest:.6g}"
    if refuses and count > MANY * np.count_nonzero(known):
        hint = f": {limit.hint}" if limit.hint else ""
        raise InputError(
            f"{where.source}: {where.at(first)}: {where.column}: expected {expected}, got {values[first]:.6g}"
            f", and {count} of {np.count_nonzero(known)} such values{hint}"
        )
    notes.append(
        f"{where}: {count} of {np.count_nonzero(known)} values removed: expected {expected}, "
        f"got {values[first]:.6g} in {where.at(first)}"
    )
    return np.where(impossible, np.nan, values)


def check_key(name: str, value: float | None, limit: str = "") -> None:
    """Raise ValueError for an impossible number in drive.toml; None passes."""
    allowed = LIMITS[limit or name]
    if value is not None and not allowed.lowest <= value <= allowed.highest:
        hint = f": {allowed.hint}" if allowed.hint and isfinite(value) else ""
        raise ValueError(f"{name}: expected {allowed.lowest:g} to {allowed.highest:g}, got {value:g}{hint}")


def reachable(times_s: Floats, positions_m: Floats, where: Location, notes: list[str]) -> Floats:
    """(N, 2) positions, nan where no car can get in time; InputError if that is half of them."""
    known = np.isfinite(positions_m).all(axis=1) & np.isfinite(times_s)
    possible = known & (np.abs(positions_m) <= LIMITS["x_m"].highest).all(axis=1)
    near = _connected(times_s, positions_m, np.flatnonzero(possible))
    unreachable = known & ~near
    result = np.where(near[:, None], positions_m, np.nan)
    if not unreachable.any() or not near.any():
        return result
    first, count = int(np.argmax(unreachable)), int(np.count_nonzero(unreachable))
    last = np.flatnonzero(near)[np.argmin(np.abs(np.flatnonzero(near) - first))]
    off_km = float(np.hypot(*(positions_m[first] - positions_m[last]))) / 1e3
    fault = f"{off_km:.3g} km from {where.at(int(last))} within {abs(times_s[first] - times_s[last]):.3g} s"
    if count > 0.5 * np.count_nonzero(known):
        raise InputError(
            f"{where.source}: {where.at(first)}: {where.column}: "
            f"expected a position that a car can reach, got one {fault}"
        )
    notes.append(
        f"{where}: {count} of {np.count_nonzero(known)} positions removed, the first in {where.at(first)}: {fault}"
    )
    return result


def _connected(times_s: Floats, positions_m: Floats, known: NDArray[np.intp]) -> Bools:
    """Which (N,) positions are connected: the longest run without a jump and all reachable from it."""
    result = np.zeros(len(times_s), np.bool_)
    result[known] = True

    def is_jump(one: int, other: int) -> bool:
        far_m = float(np.hypot(*(positions_m[other] - positions_m[one])))
        return far_m > LIMITS["speed_mps"].highest * abs(float(times_s[other] - times_s[one])) + JUMP_M

    order = [int(index) for index in known]
    jumps = [k for k in range(1, len(order)) if is_jump(order[k - 1], order[k])]
    if not jumps:
        return result
    result[:] = False
    first, stop = max(zip([0, *jumps], [*jumps, len(order)], strict=True), key=lambda run: run[1] - run[0])
    result[order[first:stop]] = True
    for onward in (order[stop - 1 :], order[first::-1]):
        last = onward[0]
        for index in onward[1:]:
            if not is_jump(last, index):
                result[index], last = True, index
    return result


def frame_times(times_s: Floats, source: str, how: str = "") -> list[str]:
    """Notes on the frames' times (N,); InputError where they are impossible."""
    where = f"{source}: times of the frames ({how})" if how else f"{source}: times of the frames"
    if len(times_s) < 2:
        raise InputError(f"{where}: expected two frames or more, got {len(times_s)}")
    steps = np.diff(times_s)
    wrong = np.flatnonzero(~(steps > 0.0) | ~np.isfinite(steps))
    if len(wrong):
        k = int(wrong[0])
        raise InputError(f"{where}: frame {k + 1}: expected a time after {times_s[k]:g} s, got {times_s[k + 1]:g} s")
    usual, limit = float(np.median(steps)), FRAME_INTERVAL_S
    if not limit.lowest <= usual <= limit.highest:
        raise InputError(
            f"{where}: expected one every {limit.lowest:g} to {limit.highest:g} s, got {usual:g} s{clock(usual)}"
        )
    if times_s[-1] - times_s[0] > LONGEST_S:
        raise InputError(f"{where}: expected at most {LONGEST_S:g} s in all, got {times_s[-1] - times_s[0]:g} s")
    return [f"a frame every {usual:g} s: too rare for tracking the flow"] if usual > SELDOM_S else []


def clock(step_s: float) -> str:
    """A guess at the unit of a time step."""
    likely = [name for scale, name in CLOCKS.items() if 0.005 <= step_s * scale <= SELDOM_S]
    return f": {likely[0]}?" if likely else ""


def brightness(images: Iterable[Image]) -> list[str]:
    """Notes on the brightness of the first images (H, W, 3)."""
    levels = [np.percentile(image[::4, ::4, 1], PARTS) for image in images]
    if not levels:
        return []
    darkest, brightest = np.median(levels, axis=0)
    if brightest < DARK:
        return [f"the first images are nearly black: grey levels up to {brightest:.0f} of 255"]
    if darkest > BRIGHT:
        return [f"the first images are nearly white: grey levels from {darkest:.0f} of 255"]
    return []


def is_blank(grey: Image) -> bool:
    """Whether an image (H, W) is of one brightness."""
    return int(grey.max()) - int(grey.min()) <= BLANK
