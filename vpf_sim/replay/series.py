"""Numeric columns over time, interpolated at the frames' times."""

import csv
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.files import read_text
from vpf_sim.geometry import unwrapped
from vpf_sim.replay.plausible import LIMITS, Location, within_limits
from vpf_sim.types import Bools, Floats

LONGEST_GAP_S = 0.5  # longest gap that is interpolated
MOST_LISTED, LONGEST_LISTED = 8, 40  # columns and letters of each in a message
SHARED_NAME = re.compile(r"^(.*) \(column \d+\)$")
DECIMAL_COMMA = re.compile(r"^([+-]?\d*),(\d+)$")


def numbers(file: Path, what: str) -> list[list[float]]:
    """Rows of finite numbers in a text file, without keys such as "P0:" and empty lines."""
    rows = []
    for number, line in enumerate(lines(file, what), 1):
        try:
            values = [float(word) for word in line.split(":", 1)[-1].split()]
        except ValueError:
            raise InputError(f"{file}: line {number}: expected numbers, got {line.strip()[:40]!r}") from None
        if not np.all(np.isfinite(values)):
            raise InputError(f"{file}: line {number}: expected finite numbers, got {line.strip()[:40]!r}")
        if values:
            rows.append(values)
    return rows


def lines(file: Path, what: str) -> list[str]:
    """The lines of a text file; `what` names the expected content."""
    try:
        return read_text(file).splitlines()
    except FileNotFoundError:
        raise InputError(f"{file}: expected {what}, found no file") from None
    except (OSError, ValueError) as error:  # ValueError: not text, or an impossible file name
        raise InputError(f"{file}: expected {what}, cannot be read: {str(error)[:200]}") from None


@dataclass(frozen=True, slots=True)
class Table:
    """The columns of a CSV file with a header, by name."""

    file: Path
    cells: dict[str, list[str]]
    lines: list[int]  # line of each row in the file

    def __contains__(self, name: object) -> bool:
        return name in self.cells

    def where(self, name: str) -> Location:
        """Location of a column's values for messages."""
        return Location(str(self.file), name, self.lines, "line")

    def texts(self, name: str) -> list[str]:
        """The cells of a column."""
        if name not in self.cells:
            raise InputError(f"{self.file}: expected a column '{name}', found {listed(self.cells)}")
        return self.cells[name]

    def numbers(self, name: str) -> Floats:
        """(M,) numbers of a column, nan for empty cells and "nan"."""
        return np.array([self._number(name, row, cell) for row, cell in enumerate(self.texts(name))])

    def signal(self, name: str, signal: str, notes: list[str], scale: float = 1.0) -> Floats:
        """(M,) a column's numbers times `scale`, in the signal's unit, without impossible values."""
        return scale * within_limits(self.numbers(name), signal, self.where(name), notes, scale)

    def times(self, name: str) -> Floats:
        """(M,) a column of ascending times."""
        return ascending(self.where(name), self.signal(name, "clock_s", []))

    def chosen(self, rows: Sequence[int]) -> "Table":
        """These rows, in this order."""
        cells = {name: [column[row] for row in rows] for name, column in self.cells.items()}
        return Table(self.file, cells, [self.lines[row] for row in rows])

    def _number(self, name: str, row: int, cell: str) -> float:
        try:
            return float(cell) if cell else np.nan
        except ValueError:
            place = f"{self.file}: line {self.lines[row]}: {name}"
            raise InputError(f"{place}: expected a number, got {cell[:40]!r}") from None


def table(file: Path, what: str) -> Table:
    """The table in a CSV file; with semicolons or tabs between cells, decimal commas are allowed."""
    text = lines(file, what)
    delimiter = max(",;\t", key=text[0].count) if text else ","
    reader = csv.reader(text, delimiter=delimiter, skipinitialspace=True)
    rows, places = [], []
    try:
        for row in reader:
            if row:
                rows.append([cell.strip() for cell in row])
                places.append(reader.line_num)
    except csv.Error as error:
        raise InputError(f"{file}: expected {what} as a CSV table, got: {error}") from None
    if len(rows) < 2:
        raise InputError(f"{file}: expected {what}: a header and rows, found {len(rows)} line(s)")
    header, *data = [[_printable(name) for name in rows[0]], *rows[1:]]
    for place, row in zip(places[1:], data, strict=True):
        if len(row) != len(header):
            raise InputError(f"{file}: line {place}: expected {len(header)} cells, got {len(row)}")
    if delimiter != ",":
        data = [[DECIMAL_COMMA.sub(r"\1.\2", cell) for cell in row] for row in data]
    return Table(file, _by_name(header, list(zip(*data, strict=True))), places[1:])


def listed(names: Collection[str]) -> str:
    """Names of columns in one line."""
    first = [name[:LONGEST_LISTED] for name in islice(names, MOST_LISTED)]
    more = len(names) - len(first)
    return ", ".join(first) + (f" and {more} more" if more > 0 else "")


def _printable(name: str) -> str:
    """The name with unprintable letters replaced."""
    return "".join(letter if letter.isprintable() else "?" for letter in name)


def _by_name(header: list[str], columns: list[tuple[str, ...]]) -> dict[str, list[str]]:
    """Columns by name; different ones of the same name get their number."""
    result: dict[str, list[str]] = {}
    for number, (name, cells) in enumerate(zip(header, columns, strict=True), 1):
        alike = all(cells == other for other_name, other in zip(header, columns, strict=True) if other_name == name)
        result[name if alike else f"{name} (column {number})"] = list(cells)
    return result


def shared_name(name: str) -> str | None:
    """The name that a column shares with different ones; None if it is unique."""
    found = SHARED_NAME.match(name)
    return found[1] if found else None


def ascending(where: Location, times_s: Floats) -> Floats:
    """The times, if ascending; else InputError."""
    wrong = np.flatnonzero(~(np.diff(times_s) > 0.0) | ~np.isfinite(np.diff(times_s)))
    if len(wrong):
        i = int(wrong[0])
        raise InputError(
            f"{where.source}: {where.at(i + 1)}: {where.column}: expected a time after that of {where.at(i)}, "
            f"got {times_s[i + 1] - times_s[i]:g} s later"
        )
    return times_s


def array(file: Path, what: str, width: int = 1) -> Floats:
    """(M, width or more) array of a .npy file with any suffix; (M,) is one column."""
    try:
        values = np.asarray(np.load(file, allow_pickle=False), np.float64)
    except FileNotFoundError:
        raise InputError(f"{file}: expected {what}, found no file") from None
    except Exception as error:  # numpy raises many kinds on damaged files
        reason = str(error).split("\n")[0][:120]
        raise InputError(f"{file}: expected {what} as a .npy array, cannot be read: {reason}") from None
    columns = values[:, None] if values.ndim == 1 else values
    if columns.ndim != 2 or not len(columns) or columns.shape[1] < width:
        raise InputError(f"{file}: expected {what} in {width} columns, got an array of shape {values.shape}")
    return columns


def at(times_s: Floats, sampled_s: Floats, values: Floats, period: float | None = None) -> Floats:
    """(N,) values (M,) linearly interpolated at times (N,); nan in gaps and beyond the ends.

    Angles have a `period` and are interpolated the shorter way round; the result is continuous.
    """
    known = np.isfinite(values) & (np.abs(sampled_s) <= LIMITS["clock_s"].highest)
    sampled_s, values = sampled_s[known], values[known]
    if not len(values):
        return np.full(len(times_s), np.nan)
    if period is not None:
        values = unwrapped(values, period)
    after = np.searchsorted(sampled_s, times_s)
    left = sampled_s[np.clip(after - 1, 0, len(values) - 1)]
    right = sampled_s[np.clip(after, 0, len(values) - 1)]
    inside = (after > 0) & (after < len(values))
    far = np.where(inside, right - left, np.minimum(np.abs(times_s - left), np.abs(times_s - right)))
    # A signal that is always sampled rarely has no gaps.
    usual_s = float(np.median(np.diff(sampled_s))) if len(values) > 1 else 0.0
    return np.where(far <= max(LONGEST_GAP_S, 1.5 * usual_s) + 1e-9, np.interp(times_s, sampled_s, values), np.nan)


def filled(times_s: Floats, values: Floats, period: float | None = None) -> tuple[Floats, Bools]:
    """The values (N,) with gaps interpolated, and which were gaps; angles have a `period`."""
    missing = ~np.isfinite(values)
    if missing.any() and not missing.all():
        known = values[~missing] if period is None else unwrapped(values[~missing], period)
        values = np.interp(times_s, times_s[~missing], known)
    return values, missing
