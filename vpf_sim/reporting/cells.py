"""Cells of a report's tables: exact value, formatted text and interval."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

Row = dict[str, Any]
NONE = "–"


@dataclass(frozen=True, slots=True)
class Column:
    """A score of a summary row."""

    key: str  # dotted, as in summary.json
    label: str
    unit: str
    digits: int
    percent: bool = False
    of_failed: bool = True  # whether `unsuccessful` has it


MAIN = (
    Column("path_mse_m2", "path MSE", "m²", 3),
    Column("accuracy.shadow.throttle.range", "throttle", "%", 1, percent=True),
    Column("accuracy.shadow.steering.range", "steering", "%", 1, percent=True),
    Column("least_clearance_m", "least clearance", "m", 2, of_failed=False),
    Column("driving_score_2_1", "driving score", "", 2, of_failed=False),
    Column("comfortable_share", "comfortable", "%", 0, percent=True, of_failed=False),
)


@dataclass(frozen=True, slots=True)
class Cell:
    """One number of a table."""

    label: str
    value: float | None
    text: str
    interval: str  # formatted, or empty
    grey: bool = False  # of unsuccessful episodes, where none succeeded


@dataclass(frozen=True, slots=True)
class DriverRow:
    """One driver's results in one scenario and weather."""

    driver: str
    privileged: str
    successes: int
    episodes: int
    interval: str  # of the success rate, formatted
    endings: str  # of the unsuccessful episodes, as text
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Group:
    """The rows of one scenario and weather, with the paper's values."""

    scenario: str
    weather: str
    paper: tuple[Cell, ...]
    rows: tuple[DriverRow, ...]


def shown(name: str) -> str:
    """The display name of a scenario or weather: a file's name without its folder."""
    return Path(name).stem if name.endswith(".toml") else name


def at(row: Row, key: str) -> Any:
    """The value under a dotted key; None if missing."""
    value: Any = row
    for part in key.split("."):
        value = value.get(part) if isinstance(value, dict) else None
    return value


def interval_of(row: Row, key: str) -> tuple[float, float] | None:
    """The 95 % interval of the value under a dotted key; None if missing."""
    ends = at(row.get("intervals") or {}, key)
    return (float(ends[0]), float(ends[1])) if isinstance(ends, list | tuple) and len(ends) == 2 else None


def formatted(value: float | None, digits: int, percent: bool = False) -> str:
    """A formatted number, with a true minus sign."""
    if value is None:
        return NONE
    text = f"{100.0 * value if percent else value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text.replace("-", "−")


def interval_text(ends: tuple[float, float] | None, digits: int, percent: bool = False) -> str:
    return "" if ends is None else " to ".join(formatted(end, digits, percent) for end in ends)


def cell(row: Row, column: Column) -> Cell:
    """The cell with the mean of the successful episodes, or else of the others in grey."""
    value = at(row, column.key)
    if value is not None or row["successes"] or not column.of_failed:
        ends = interval_of(row, column.key)
        interval = interval_text(ends, column.digits, column.percent)
        return Cell(column.label, value, formatted(value, column.digits, column.percent), interval)
    value = at(row.get("unsuccessful") or {}, column.key)
    return Cell(column.label, value, formatted(value, column.digits, column.percent), "", value is not None)


def groups(rows: Sequence[Row], order: "Order") -> list[Group]:
    """The main table, grouped by scenario and weather."""
    ordered = sorted(rows, key=order.place)
    return [
        Group(shown(scenario), shown(weather), _paper(found := list(group)), tuple(driver_row(row) for row in found))
        for (scenario, weather), group in groupby(ordered, key=lambda row: (row["scenario"], row["weather"]))
    ]


def driver_row(row: Row) -> DriverRow:
    """The main table's row of a driver."""
    return DriverRow(
        row["driver"],
        row["privileged"],
        row["successes"],
        row["episodes"],
        interval_text(interval_of(row, "success_rate"), 0, percent=True),
        endings(row),
        tuple(cell(row, column) for column in MAIN),
    )


def endings(row: Row) -> str:
    """How the unsuccessful episodes ended: "3 collision, 1 off road"."""
    counts = [
        f"{count} {status.replace('_', ' ')}"
        for status, count in sorted(row["statuses"].items())
        if status != "success"
    ]
    missing = row["episodes"] - sum(row["statuses"].values())
    return ", ".join([*counts, *([f"{missing} not driven"] if missing else [])])


def _paper(rows: Sequence[Row]) -> tuple[Cell, ...]:
    """The paper's row in the main table's columns; empty if it has none."""
    paper = rows[0].get("paper")
    if not paper:
        return ()
    values = {
        "path_mse_m2": Cell("path MSE", paper["path_mse_m2"], formatted(paper["path_mse_m2"], 2), ""),
        "accuracy.shadow.throttle.range": Cell(
            "throttle", paper["throttle"], formatted(paper["throttle"], 2, True), ""
        ),
        "accuracy.shadow.steering.range": Cell(
            "steering", paper["steering"], formatted(paper["steering"], 2, True), ""
        ),
    }
    return tuple(values.get(column.key, Cell(column.label, None, NONE, "")) for column in MAIN)


@dataclass(frozen=True, slots=True)
class Order:
    """The order of scenarios, weathers and drivers in the plan; it also gives the drivers' colours."""

    scenarios: tuple[str, ...]
    weathers: tuple[str, ...]
    drivers: tuple[str, ...]

    def place(self, row: Row) -> tuple[int, int, int]:
        """The sort key of a row or a record."""
        return (
            self.scenarios.index(row["scenario"]),
            self.weathers.index(row["weather"]),
            self.drivers.index(row["driver"]),
        )

    def style(self, driver: str) -> str:
        """The CSS class of a driver's colour, one of eight."""
        return f"d{self.drivers.index(driver) % 8}"

    def cells(self) -> Iterator[tuple[str, str]]:
        """Every pair of scenario and weather."""
        return ((scenario, weather) for scenario in self.scenarios for weather in self.weathers)
