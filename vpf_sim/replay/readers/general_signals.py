"""The table of signals beside anyone's recording: columns with units in their names, laid onto the frames' times."""

from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, derived, places, series
from vpf_sim.replay.drive_file import SignalKeys, VehicleKeys
from vpf_sim.types import Floats

TIME, FILE = "time_s", "file"
DEGREES = float(np.pi / 180.0)
# By signal: the columns that may hold it, and what their unit is in ours.
SPEED = {"speed_mps": 1.0, "speed_kmh": 1.0 / 3.6, "speed_mph": 0.44704}
YAW_RATE = {"yaw_rate_radps": 1.0, "yaw_rate_degps": DEGREES}
WHEEL = {"steering_wheel_rad": 1.0, "steering_wheel_deg": DEGREES}
STEERING = {"steering_rad": 1.0, "steering_deg": DEGREES}
ACCELERATION = {"acceleration_mps2": 1.0, "acceleration_g": 9.80665}
THROTTLE = {"throttle": 1.0, "throttle_percent": 0.01}
BRAKE = {"brake": 1.0, "brake_percent": 0.01}
YAW = {"yaw_rad": 1.0, "yaw_deg": DEGREES}
PLAIN = {"obstacle": 1.0, "lead_gap_m": 1.0, "x_m": 1.0, "y_m": 1.0, "latitude_deg": 1.0, "longitude_deg": 1.0}
KNOWN = (*SPEED, *YAW_RATE, *WHEEL, *STEERING, *ACCELERATION, *THROTTLE, *BRAKE, *YAW, *PLAIN, TIME, FILE)

MOST_LISTED = 8  # columns, in a note
RARE_S = 2.0  # between rows; a logger is faster, unless its clock counts milliseconds


class Table:
    """The columns under our names, at the times of the frames."""

    def __init__(self, file: Path, keys: SignalKeys, times_s: Floats, names: tuple[str, ...]) -> None:
        self.file = file
        self.columns = named(file, keys)
        self._left = keys.left_is_positive
        self._times_s = times_s
        self._rows = self._rows_of(names) if names and FILE in self.columns else None
        if self._rows is None:
            if TIME not in self.columns:
                raise InputError(f"{file}: expected a column '{TIME}', found {', '.join(self.columns)}")
            self._sampled_s = series.ascending(file, series.column(file, self.columns, TIME)) + keys.offset_s

    def take(self, units: dict[str, float], sided: str = "") -> tuple[Floats, str] | None:
        """(N,) in our unit and sign, and the column's name; None if there is no such column."""
        found = [name for name in units if name in self.columns]
        if len(found) > 1:
            raise InputError(f"{self.file}: expected one of the columns {', '.join(units)}, found {', '.join(found)}")
        if not found:
            return None
        values = series.column(self.file, self.columns, found[0]) * units[found[0]]
        sign = -1.0 if sided in self._left else 1.0
        if self._rows is not None:
            return sign * values[self._rows], found[0]
        return sign * series.at(self._times_s, self._sampled_s, values), found[0]

    def check_overlap(self) -> None:
        """A table of which no row is near a frame has another clock: that is no gap, but a mistake."""
        if self._rows is not None:
            return
        first, last = float(self._sampled_s[0]), float(self._sampled_s[-1])
        end = float(self._times_s[-1])
        if last < -series.LONGEST_GAP_S or first > end + series.LONGEST_GAP_S:
            raise InputError(
                f"{self.file}: expected rows at the frames' times, 0 to {end:.1f} s, got {first:.1f} to {last:.1f} s; "
                "signals.offset_s in drive.toml is added to them"
            )

    def notes(self) -> list[str]:
        """What of the table serves for nothing: columns that are not known, as with another unit, and empty ones."""
        unknown = [name for name in self.columns if name and name not in KNOWN]
        empty = [name for name in self.columns if name in KNOWN and name != FILE and not self._has_values(name)]
        told = [("not used", unknown), ("without a value", empty)]
        notes = [f"{self.file.name}: {what}: {_listed(names)}" for what, names in told if names]
        if self._rows is None and len(self._sampled_s) > 1:
            step_s = float(np.median(np.diff(self._sampled_s)))
            if step_s > RARE_S:
                notes.append(f"{self.file.name}: a row every {step_s:g} s, interpolated")
        return notes

    def _has_values(self, name: str) -> bool:
        return bool(np.isfinite(series.column(self.file, self.columns, name)).any())

    def _rows_of(self, names: tuple[str, ...]) -> list[int]:
        """The row of each picture."""
        place = {Path(cell).name: row for row, cell in enumerate(self.columns[FILE])}
        missing = [name for name in names if name not in place]
        if missing:
            raise InputError(f"{self.file}: expected a row for each picture, found none for {missing[0]}")
        return [place[name] for name in names]


def _listed(names: list[str]) -> str:
    more = len(names) - MOST_LISTED
    return ", ".join(names[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def named(file: Path, keys: SignalKeys) -> dict[str, list[str]]:
    """The table's columns under our names; others are left alone."""
    columns = series.table(file, "signals")
    for ours, theirs in keys.columns:
        if ours not in KNOWN:
            raise InputError(f"drive.toml: signals.columns: unknown signal '{ours}'; known: {', '.join(KNOWN)}")
        if theirs not in columns:
            raise InputError(f"{file}: expected a column '{theirs}' for {ours}, found {', '.join(columns)}")
    renamed = {theirs: ours for ours, theirs in keys.columns}
    return {renamed.get(name, name): cells for name, cells in columns.items()}


def frame_times(folder: Path, keys: SignalKeys, names: tuple[str, ...]) -> Floats | None:
    """(N,) s, the times of pictures by the table's rows of their names; None if it has none."""
    file = folder / keys.file
    if not file.exists():
        return None
    columns = named(file, keys)
    if not {TIME, FILE} <= set(columns):
        return None
    times = dict(zip((Path(cell).name for cell in columns[FILE]), series.column(file, columns, TIME), strict=True))
    missing = [name for name in names if name not in times]
    if missing:
        raise InputError(f"{file}: expected a row for each picture, found none for {missing[0]}")
    return series.ascending(file, np.array([times[name] for name in names]))


def put(source: assemble.Source, file: Path, keys: SignalKeys, vehicle: VehicleKeys, names: tuple[str, ...]) -> None:
    """Every signal that the table has."""
    table = Table(file, keys, source.times_s, names)
    table.check_overlap()
    for signal, units, sided in (
        ("speed_mps", SPEED, ""),
        ("yaw_rate_radps", YAW_RATE, "yaw_rate"),
        ("steering_rad", STEERING, "steering"),
        ("obstacle", {"obstacle": 1.0}, ""),
        ("lead_gap_m", {"lead_gap_m": 1.0}, ""),
    ):
        if (found := table.take(units, sided)) is not None:
            source.put(signal, found[0], f"{file.name} {found[1]}")
    _wheel(source, table, vehicle)
    _pedals(source, table)
    _poses(source, table)
    source.notes.extend(table.notes())


def _wheel(source: assemble.Source, table: Table, vehicle: VehicleKeys) -> None:
    found = table.take(WHEEL, "steering")
    if found is None:
        return
    if vehicle.steering_ratio is None:
        raise InputError(f"{table.file}: {found[1]}: expected steering_ratio in drive.toml [vehicle], found none")
    ratio = vehicle.steering_ratio
    source.put("steering_rad", found[0] / ratio, f"{table.file.name} {found[1]} over the steering ratio {ratio:g}")


def _pedals(source: assemble.Source, table: Table) -> None:
    """An acceleration comes first: pedals hold a speed too, and the driver's command is an acceleration."""
    acceleration, throttle, brake = (table.take(units) for units in (ACCELERATION, THROTTLE, BRAKE))
    name = table.file.name
    if acceleration is not None:
        how = f"{name} {acceleration[1]}; full throttle 3 m/s2, full brake 6 m/s2"
        source.put("throttle", derived.throttle(acceleration[0]), how)
    elif throttle is not None:
        pedals = throttle[0] if brake is None else throttle[0] - brake[0]
        used = throttle[1] if brake is None else f"{throttle[1]} less {brake[1]}"
        source.put("throttle", np.clip(pedals, -1.0, 1.0), f"{name} {used}")


def _poses(source: assemble.Source, table: Table) -> None:
    """By x, y, yaw, or by latitude and longitude with the course for a heading."""
    x, y, yaw = table.take({"x_m": 1.0}), table.take({"y_m": 1.0}, "y"), table.take(YAW, "yaw")
    if x is not None and y is not None:
        flat = np.stack([series.filled(part[0])[0] for part in (x, y)], axis=1)
        how = f"{table.file.name} x_m, y_m"
        heading = places.course(source.times_s, flat) if yaw is None else np.unwrap(series.filled(yaw[0])[0])
        source.heading_recorded = yaw is not None
        source.put("poses", np.column_stack([flat, heading]), how + ("; heading by the course" if yaw is None else ""))
        return
    place = [table.take({name: 1.0}) for name in ("latitude_deg", "longitude_deg")]
    if place[0] is not None and place[1] is not None:
        flat = places.north_east(series.filled(place[0][0])[0], series.filled(place[1][0])[0])
        way = places.way(flat, places.course(source.times_s, flat))
        source.heading_recorded = False
        source.put("poses", way, f"{table.file.name} latitude_deg, longitude_deg; heading by the course")
