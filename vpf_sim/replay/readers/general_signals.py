"""The table of signals beside your own recording, interpolated at the frames' times."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, derived, image_files, paths, plausible, series
from vpf_sim.replay.drive_file import SignalKeys, VehicleKeys
from vpf_sim.types import Floats

TIME, FILE = "time_s", "file"
DEGREES = float(np.pi / 180.0)
# Columns that may hold each signal, with their unit in ours.
SPEED = {"speed_mps": 1.0, "speed_kmh": 1.0 / 3.6, "speed_mph": 0.44704}
YAW_RATE = {"yaw_rate_radps": 1.0, "yaw_rate_degps": DEGREES}
WHEEL = {"steering_wheel_rad": 1.0, "steering_wheel_deg": DEGREES}
STEERING = {"steering_rad": 1.0, "steering_deg": DEGREES}
ACCELERATION = {"acceleration_mps2": 1.0, "acceleration_g": 9.80665}
THROTTLE = {"throttle": 1.0, "throttle_percent": 0.01}
BRAKE = {"brake": 1.0, "brake_percent": 0.01}
YAW = {"yaw_rad": 1.0, "yaw_deg": DEGREES}
OBSTACLE, GAP, X, Y = ({name: 1.0} for name in ("obstacle", "lead_gap_m", "x_m", "y_m"))
LATITUDE, LONGITUDE = {"latitude_deg": 1.0}, {"longitude_deg": 1.0}
PLAIN = (*OBSTACLE, *GAP, *X, *Y, *LATITUDE, *LONGITUDE)
KNOWN = (*SPEED, *YAW_RATE, *WHEEL, *STEERING, *ACCELERATION, *THROTTLE, *BRAKE, *YAW, *PLAIN, TIME, FILE)

RARE_S = 2.0  # between rows; slower suggests milliseconds


class Signals:
    """The columns under our names, units and signs, at their own times or the frames' times."""

    def __init__(self, file: Path, keys: SignalKeys, times_s: Floats, names: tuple[str, ...], notes: list[str]) -> None:
        """`names` are those of the N images, "" for a missing one; empty for a video."""
        self.file = file
        self.table = named(file, keys)
        self._left = keys.left_is_positive
        self._frames_s = times_s
        self._notes = notes
        if names and FILE in self.table:
            rows = image_rows(self.table)
            self._missing = np.array([not name for name in names])
            self.table = self.table.chosen([_row(self.table, rows, name) if name else 0 for name in names])
            self.sampled_s = times_s
        else:
            self._missing = np.zeros(len(self.table.lines), np.bool_)
            self.sampled_s = self.table.times(TIME) + keys.offset_s
            self._check_overlap()

    def samples(self, units: dict[str, float], signal: str, sided: str = "") -> tuple[Floats, str] | None:
        """(M,) at the table's own times, and the column's name; None without such a column."""
        found = [name for name in units if name in self.table]
        if len(found) > 1:
            raise InputError(f"{self.file}: expected one of the columns {', '.join(units)}, found {', '.join(found)}")
        if not found:
            return None
        values = self.table.signal(found[0], signal, self._notes, units[found[0]])
        return np.where(self._missing, np.nan, -values if sided in self._left else values), found[0]

    def take(self, units: dict[str, float], signal: str, sided: str = "") -> tuple[Floats, str] | None:
        """(N,) at the frames' times, and the column's name; None without such a column."""
        found = self.samples(units, signal, sided)
        return None if found is None else (series.at(self._frames_s, self.sampled_s, found[0]), found[1])

    def where(self, name: str) -> plausible.Location:
        return self.table.where(name)

    def _check_overlap(self) -> None:
        """Refuse a table without a row near any frame: it has another clock."""
        first, last = float(self.sampled_s[0]), float(self.sampled_s[-1])
        end = float(self._frames_s[-1])
        if last < -series.LONGEST_GAP_S or first > end + series.LONGEST_GAP_S:
            raise InputError(
                f"{self.file}: expected rows at the frames' times, 0 to {end:.1f} s, got {first:.1f} to {last:.1f} s; "
                "signals.offset_s in drive.toml is added to them"
            )

    def unused(self) -> list[str]:
        """Notes on unknown and empty columns, and on rare rows."""
        unknown = [name for name in self.table.cells if name and name not in KNOWN]
        empty = [name for name in self.table.cells if name in KNOWN and name != FILE and not self._has_values(name)]
        lists = [("not used", unknown), ("without a value", empty)]
        notes = [f"{self.file.name}: {what}: {series.listed(names)}" for what, names in lists if names]
        if self.sampled_s is not self._frames_s and len(self.sampled_s) > 1:
            step_s = float(np.median(np.diff(self.sampled_s)))
            if step_s > RARE_S:
                notes.append(f"{self.file.name}: a row every {step_s:g} s, interpolated{plausible.clock(step_s)}")
        return notes

    def _has_values(self, name: str) -> bool:
        return bool(np.isfinite(self.table.numbers(name)).any())


def named(file: Path, keys: SignalKeys) -> series.Table:
    """The table with columns renamed to ours."""
    table = series.table(file, "signals")
    for ours, theirs in keys.columns.items():
        if ours not in KNOWN:
            raise InputError(f"drive.toml: signals.columns: unknown signal '{ours}'; known: {', '.join(KNOWN)}")
        if theirs not in table:
            raise InputError(f"{file}: expected a column '{theirs}' for {ours}, found {series.listed(table.cells)}")
    renamed = {theirs: ours for ours, theirs in keys.columns.items()}
    result = [renamed.get(name, name) for name in table.cells]
    for name in result:
        shared = name if result.count(name) > 1 else series.shared_name(name)
        if shared in KNOWN:
            raise InputError(f"{file}: expected one column '{shared}', found several that differ")
    return replace(table, cells=dict(zip(result, table.cells.values(), strict=True)))


def image_rows(table: series.Table) -> dict[str, int]:
    """The row of each image by its file name; folders are those of the recording machine."""
    rows: dict[str, int] = {}
    for row, cell in enumerate(table.texts(FILE)):
        name = image_files.name_of(cell)
        if name and name in rows:
            lines = f"{table.lines[rows[name]]} and {table.lines[row]}"
            raise InputError(f"{table.file}: {FILE}: expected one row for {name}, found lines {lines}")
        rows[name] = row
    return rows


def _row(table: series.Table, rows: dict[str, int], name: str) -> int:
    if name not in rows:
        raise InputError(f"{table.file}: expected a row for each image, found none for {name}")
    return rows[name]


def frame_times(folder: Path, keys: SignalKeys, names: tuple[str, ...], notes: list[str]) -> Floats | None:
    """(N,) s, times of the images by the table's rows; None if it has none."""
    file = image_files.resolve(folder, keys.file)
    if not file.exists():
        return None
    table = named(file, keys)
    if TIME not in table or FILE not in table:
        return None
    rows = image_rows(table)
    absent = [name for name in rows if name and name not in names]
    if absent:
        notes.append(f"{file.name}: {len(absent)} of {len(rows)} images are missing, the first is {absent[0]}")
    return table.chosen([_row(table, rows, name) for name in names]).times(TIME)


def put(source: assemble.Source, file: Path, keys: SignalKeys, vehicle: VehicleKeys, names: tuple[str, ...]) -> None:
    """Store every signal of the table."""
    signals = Signals(file, keys, source.times_s, names, source.notes)
    for signal, units, sided in (
        ("speed_mps", SPEED, ""),
        ("yaw_rate_radps", YAW_RATE, "yaw_rate"),
        ("steering_rad", STEERING, "steering"),
        ("obstacle", OBSTACLE, ""),
        ("lead_gap_m", GAP, ""),
    ):
        if (found := signals.take(units, signal, sided)) is not None:
            source.put(signal, found[0], f"{file.name} {found[1]}")
    _wheel(source, signals, vehicle)
    _pedals(source, signals)
    _poses(source, signals)
    source.notes.extend(signals.unused())


def _wheel(source: assemble.Source, signals: Signals, vehicle: VehicleKeys) -> None:
    ratio = vehicle.steering_ratio
    units = {name: unit / (ratio or 1.0) for name, unit in WHEEL.items()}
    column = next((name for name in WHEEL if name in signals.table), None)
    if column is not None and ratio is None:
        raise InputError(f"{signals.file}: {column}: expected steering_ratio in drive.toml [vehicle], found none")
    found = signals.take(units, "steering_rad", "steering")
    if found is not None:
        source.put("steering_rad", found[0], f"{signals.file.name} {found[1]} over the steering ratio {ratio:g}")


def _pedals(source: assemble.Source, signals: Signals) -> None:
    """Store the throttle; an acceleration has priority, since the command is an acceleration."""
    acceleration = signals.take(ACCELERATION, "acceleration_mps2")
    throttle, brake = (signals.take(units, "pedal") for units in (THROTTLE, BRAKE))
    name = signals.file.name
    if acceleration is not None:
        how = f"{name} {acceleration[1]}; full throttle 3 m/s2, full brake 6 m/s2"
        source.put("throttle", derived.throttle(acceleration[0]), how)
    elif throttle is not None:
        command = throttle[0] if brake is None else throttle[0] - brake[0]
        used = throttle[1] if brake is None else f"{throttle[1]} less {brake[1]}"
        source.put("throttle", np.clip(command, -1.0, 1.0), f"{name} {used}")


def _poses(source: assemble.Source, signals: Signals) -> None:
    """Store poses by x, y, yaw, or by latitude and longitude with the course as heading."""
    x, y, yaw = signals.samples(X, "x_m"), signals.samples(Y, "y_m", "y"), signals.samples(YAW, "yaw_rad", "yaw")
    if x is not None and y is not None:
        where = signals.where("x_m")
        flat = plausible.reachable(signals.sampled_s, np.stack([x[0], y[0]], axis=1), where, source.notes)
        how = f"{signals.file.name} x_m, y_m"
        source.heading_recorded = yaw is not None
        course = paths.course(signals.sampled_s, flat) if yaw is None else yaw[0]
        path = np.column_stack([flat, course])
        how += "; course as heading" if yaw is None else ""
    else:
        position = [signals.samples(LATITUDE, "latitude_deg"), signals.samples(LONGITUDE, "longitude_deg")]
        if position[0] is None or position[1] is None:
            return
        where = signals.where("latitude_deg")
        flat = paths.fixes(signals.sampled_s, position[0][0], position[1][0], where, source.notes)
        path = paths.poses(flat, paths.course(signals.sampled_s, flat))
        source.heading_recorded = False
        how = f"{signals.file.name} latitude_deg, longitude_deg; course as heading"
    source.put("poses", derived.poses_at(source.times_s, signals.sampled_s, path), how)
