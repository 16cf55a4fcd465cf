"""What the recording of a road vehicle can hold: the limits of every value, and what becomes of one beyond them.

A few impossible values are faults of a logger: they become gaps, and a note says so. Many of them mean that a column
is not what its name says, mostly that it has another unit: that is an InputError. `agreement` holds the signals that
are possible one by one against each other.
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
    """What a value can be, and what one beyond it often is."""

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
    "clock_s": Limit(-1e11, 1e11, "milliseconds or less?"),  # since 1970, too
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
MANY = 0.2  # of the values: more than this beyond the limits is no fault of a logger
JUMP_M = 20.0  # by which a receiver may correct itself
FRAME_INTERVAL_S, SELDOM_S = Limit(1e-3, 5.0), 0.5  # the median's; flow cannot be followed over more
LONGEST_S = 1e6  # of a drive
CLOCKS = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds"}
DARK, BRIGHT, BLANK = 24, 231, 4  # grey levels: of the brightest, the darkest part of a picture, and between them
PARTS = (1.0, 99.0)  # percentiles


@dataclass(frozen=True, slots=True)
class Where:
    """How messages call a sequence of values, and the place of each."""

    source: str  # the file, with its path
    column: str
    places: Sequence[int] | None = None  # in the file; None: counted from 0
    unit: str = "row"  # of the places

    def at(self, index: int) -> str:
        return f"{self.unit} {index if self.places is None else self.places[index]}"

    def __str__(self) -> str:
        return f"{self.source.rsplit('/', 1)[-1]}: {self.column}"


def kept(
    values: Floats, signal: str, where: Where, notes: list[str], scale: float = 1.0, refuses: bool = True
) -> Floats:
    """(N,) the values, nan where no car can have them; `scale` is their unit in that of the signal's limits.

    Raises InputError where many are impossible, unless only told so.
    """
    limit = LIMITS[signal]
    lowest, highest = limit.lowest / abs(scale), limit.highest / abs(scale)
    told = ~np.isnan(values)
    impossible = told & ~((values >= lowest - 1e-9) & (values <= highest + 1e-9))
    if not impossible.any():
        return values
    first, count = int(np.argmax(impossible)), int(np.count_nonzero(impossible))
    expected = f"{lowest:.6g} to {highest:.6g}"
    if refuses and count > MANY * np.count_nonzero(told):
        hint = f": {limit.hint}" if limit.hint else ""
        raise InputError(
            f"{where.source}: {where.at(first)}: {where.column}: expected {expected}, got {values[first]:.6g}"
            f", and {count} of {np.count_nonzero(told)} values like it{hint}"
        )
    notes.append(
        f"{where}: {count} of {np.count_nonzero(told)} values left out: expected {expected}, "
        f"got {values[first]:.6g} in {where.at(first)}"
    )
    return np.where(impossible, np.nan, values)


def key(name: str, value: float | None, limit: str = "") -> None:
    """Refuse a number of drive.toml that cannot be, by ValueError; one that is left out is none."""
    known = LIMITS[limit or name]
    if value is not None and not known.lowest <= value <= known.highest:
        hint = f": {known.hint}" if known.hint and isfinite(value) else ""
        raise ValueError(f"{name}: expected {known.lowest:g} to {known.highest:g}, got {value:g}{hint}")


def reached(times_s: Floats, places_m: Floats, where: Where, notes: list[str]) -> Floats:
    """(N, 2) the places, nan where no car can have come from the others in time; InputError where that is half."""
    known = np.isfinite(places_m).all(axis=1) & np.isfinite(times_s)
    possible = known & (np.abs(places_m) <= LIMITS["x_m"].highest).all(axis=1)
    near = _connected(times_s, places_m, np.flatnonzero(possible))
    astray = known & ~near
    result = np.where(near[:, None], places_m, np.nan)
    if not astray.any() or not near.any():
        return result
    first, count = int(np.argmax(astray)), int(np.count_nonzero(astray))
    last = np.flatnonzero(near)[np.argmin(np.abs(np.flatnonzero(near) - first))]
    off_km = float(np.hypot(*(places_m[first] - places_m[last]))) / 1e3
    fault = f"{off_km:.3g} km from {where.at(int(last))} within {abs(times_s[first] - times_s[last]):.3g} s"
    if count > 0.5 * np.count_nonzero(known):
        raise InputError(
            f"{where.source}: {where.at(first)}: {where.column}: expected a place that a car reaches, got one {fault}"
        )
    notes.append(
        f"{where}: {count} of {np.count_nonzero(known)} places left out, the first in {where.at(first)}: {fault}"
    )
    return result


def _connected(times_s: Floats, places_m: Floats, known: NDArray[np.intp]) -> Bools:
    """Which (N,) places a car can have driven through: the longest run without a jump, and all that it reaches."""
    result = np.zeros(len(times_s), np.bool_)
    result[known] = True

    def is_jump(one: int, other: int) -> bool:
        far_m = float(np.hypot(*(places_m[other] - places_m[one])))
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
    """What is to be told of the frames' times (N,); InputError where they cannot be."""
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
    return [f"a frame every {usual:g} s: too seldom for the flow to be followed"] if usual > SELDOM_S else []


def clock(step_s: float) -> str:
    """A guess at the unit in which a step between times is a usual one."""
    likely = [name for scale, name in CLOCKS.items() if 0.005 <= step_s * scale <= SELDOM_S]
    return f": {likely[0]}?" if likely else ""


def brightness(images: Iterable[Image]) -> list[str]:
    """What is to be told of how bright the first pictures (H, W, 3) are."""
    levels = [np.percentile(image[::4, ::4, 1], PARTS) for image in images]
    if not levels:
        return []
    darkest, brightest = np.median(levels, axis=0)
    if brightest < DARK:
        return [f"the first pictures are nearly black: grey levels up to {brightest:.0f} of 255"]
    if darkest > BRIGHT:
        return [f"the first pictures are nearly white: grey levels from {darkest:.0f} of 255"]
    return []


def is_blank(grey: Image) -> bool:
    """Whether a picture (H, W) is all of one brightness: nothing is to be seen in it."""
    return int(grey.max()) - int(grey.min()) <= BLANK
