"""Columns of numbers over time, laid onto the times of the frames; what is missing is told."""

import csv
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.types import Bools, Floats

LONGEST_GAP_S = 0.5  # over which a signal is interpolated


def numbers(file: Path, what: str) -> list[list[float]]:
    """The rows of finite numbers of a text file; a leading key such as "P0:" is left out, empty lines are skipped."""
    rows = []
    for number, line in enumerate(lines(file, what), 1):
        try:
            values = [float(word) for word in line.split(":", 1)[-1].split()]
        except ValueError:
            raise InputError(f"{file}: line {number}: expected numbers, got '{line.strip()[:40]}'") from None
        if not np.all(np.isfinite(values)):
            raise InputError(f"{file}: line {number}: expected finite numbers, got '{line.strip()[:40]}'")
        if values:
            rows.append(values)
    return rows


def lines(file: Path, what: str) -> list[str]:
    """The lines of a text file; `what` is what it should hold."""
    try:
        return file.read_text("utf-8-sig").splitlines()
    except FileNotFoundError:
        raise InputError(f"{file}: expected {what}, found no file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file}: expected {what}, cannot be read: {error}") from None


def table(file: Path, what: str) -> dict[str, list[str]]:
    """The columns of a CSV file with a header, by name."""
    try:
        rows = list(csv.reader(lines(file, what)))
    except csv.Error as error:
        raise InputError(f"{file}: expected {what} as a CSV table, got: {error}") from None
    if len(rows) < 2:
        raise InputError(f"{file}: expected {what}: a header and rows, found {len(rows)} line(s)")
    header = [name.strip() for name in rows[0]]
    for number, row in enumerate(rows[1:], 2):
        if row and len(row) != len(header):
            raise InputError(f"{file}: line {number}: expected {len(header)} cells, got {len(row)}")
    filled = [row for row in rows[1:] if row]
    return {name: [row[i].strip() for row in filled] for i, name in enumerate(header)}


def column(file: Path, columns: dict[str, list[str]], name: str) -> Floats:
    """(M,) the numbers of a column, nan where a cell is empty or says nan."""
    if name not in columns:
        raise InputError(f"{file}: expected a column '{name}', found {', '.join(columns)}")
    result = []
    for number, cell in enumerate(columns[name], 2):
        try:
            result.append(float(cell) if cell else np.nan)
        except ValueError:
            raise InputError(f"{file}: line {number}: {name}: expected a number, got '{cell[:40]}'") from None
    return np.array(result)


def ascending(file: Path, times_s: Floats) -> Floats:
    """The times, if each is after the one before."""
    wrong = np.flatnonzero(~(np.diff(times_s) > 0.0))
    if len(wrong):
        i = int(wrong[0])
        before, after = times_s[i : i + 2] - times_s[0]
        raise InputError(
            f"{file}: row {i + 2}: expected a time after that of row {i + 1}, got {after - before:g} s later"
        )
    return times_s


def array(file: Path, what: str) -> Floats:
    """The array of a .npy file, whatever its suffix."""
    try:
        return np.asarray(np.load(file, allow_pickle=False), np.float64)
    except FileNotFoundError:
        raise InputError(f"{file}: expected {what}, found no file") from None
    except (OSError, ValueError, EOFError) as error:
        reason = str(error).split("\n")[0][:120]
        raise InputError(f"{file}: expected {what} as a .npy array, cannot be read: {reason}") from None


def at(times_s: Floats, sampled_s: Floats, values: Floats, longest_gap_s: float = LONGEST_GAP_S) -> Floats:
    """(N,) values (M,) by linear interpolation at times (N,); nan in gaps and beyond the ends by more than the gap."""
    known = np.isfinite(values) & np.isfinite(sampled_s)
    sampled_s, values = sampled_s[known], values[known]
    if not len(values):
        return np.full(len(times_s), np.nan)
    after = np.searchsorted(sampled_s, times_s)
    left = sampled_s[np.clip(after - 1, 0, len(values) - 1)]
    right = sampled_s[np.clip(after, 0, len(values) - 1)]
    inside = (after > 0) & (after < len(values))
    far = np.where(inside, right - left, np.minimum(np.abs(times_s - left), np.abs(times_s - right)))
    # Gaps are those of a signal that is sampled more often; one sampled rarely is interpolated all the same.
    allowed = max(longest_gap_s, 1.5 * float(np.median(np.diff(sampled_s)))) if len(values) > 1 else longest_gap_s
    return np.where(far <= allowed + 1e-9, np.interp(times_s, sampled_s, values), np.nan)


def filled(values: Floats) -> tuple[Floats, Bools]:
    """The values with their gaps bridged in a straight line, and which (N,) were bridged."""
    missing = ~np.isfinite(values)
    if missing.any() and not missing.all():
        index = np.arange(len(values))
        values = np.interp(index, index[~missing], values[~missing])
    return values, missing
