"""The numbers of a summary as cells of tables: each with its exact value, its words and its interval."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

Row = dict[str, Any]
NONE = "–"


@dataclass(frozen=True, slots=True)
class Column:
    """A score of a summary's row."""

    key: str  # dotted, as in summary.json
    label: str
    unit: str
    digits: int
    percent: bool = False
    of_failed: bool = True  # whether `unsuccessful` has it too


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
    words: str
    interval: str  # in words, or empty
    grey: bool = False  # of the episodes without success, where none had any


@dataclass(frozen=True, slots=True)
class DriverRow:
    """What one driver did in one scenario and weather."""

    driver: str
    privileged: str
    successes: int
    episodes: int
    interval: str  # of the share, in words
    endings: str  # of the others, in words
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Group:
    """The rows of one scenario and weather, and what the paper has for it."""

    scenario: str
    weather: str
    paper: tuple[Cell, ...]
    rows: tuple[DriverRow, ...]


def shown(name: str) -> str:
    """A scenario or weather as a page names it: of a file the name without its folder."""
    return Path(name).stem if name.endswith(".toml") else name


def at(row: Row, key: str) -> Any:
    """The value under a dotted key, None where there is none."""
    value: Any = row
    for part in key.split("."):
        value = value.get(part) if isinstance(value, dict) else None
    return value


def interval_of(row: Row, key: str) -> tuple[float, float] | None:
    """The 95 % interval of the value under a dotted key, where the summary has one."""
    ends = at(row.get("intervals") or {}, key)
    return (float(ends[0]), float(ends[1])) if isinstance(ends, list | tuple) and len(ends) == 2 else None


def worded(value: float | None, digits: int, percent: bool = False) -> str:
    """A number to read, with a true minus sign."""
    if value is None:
        return NONE
    text = f"{100.0 * value if percent else value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text.replace("-", "−")


def interval_words(ends: tuple[float, float] | None, digits: int, percent: bool = False) -> str:
    return "" if ends is None else " to ".join(worded(end, digits, percent) for end in ends)


def cell(row: Row, column: Column) -> Cell:
    """The mean of the successful episodes, or else that of the others, in grey."""
    value = at(row, column.key)
    if value is not None or row["successes"] or not column.of_failed:
        ends = interval_of(row, column.key)
        words = interval_words(ends, column.digits, column.percent)
        return Cell(column.label, value, worded(value, column.digits, column.percent), words)
    value = at(row.get("unsuccessful") or {}, column.key)
    return Cell(column.label, value, worded(value, column.digits, column.percent), "", value is not None)


def groups(rows: Sequence[Row], order: "Order") -> list[Group]:
    """The main table."""
    ordered = sorted(rows, key=order.place)
    return [
        Group(shown(scenario), shown(weather), _paper(found := list(group)), tuple(driver_row(row) for row in found))
        for (scenario, weather), group in groupby(ordered, key=lambda row: (row["scenario"], row["weather"]))
    ]


def driver_row(row: Row) -> DriverRow:
    """A driver's cells."""
    return DriverRow(
        row["driver"],
        row["privileged"],
        row["successes"],
        row["episodes"],
        interval_words(interval_of(row, "success_rate"), 0, percent=True),
        endings(row),
        tuple(cell(row, column) for column in MAIN),
    )


def endings(row: Row) -> str:
    """How the episodes without success ended: "3 collision, 1 off road"."""
    told = [
        f"{count} {status.replace('_', ' ')}"
        for status, count in sorted(row["statuses"].items())
        if status != "success"
    ]
    missing = row["episodes"] - sum(row["statuses"].values())
    return ", ".join([*told, *([f"{missing} not driven"] if missing else [])])


def _paper(rows: Sequence[Row]) -> tuple[Cell, ...]:
    """The paper's row, in the main table's columns; empty where it has none."""
    paper = rows[0].get("paper")
    if not paper:
        return ()
    known = {
        "path_mse_m2": Cell("path MSE", paper["path_mse_m2"], worded(paper["path_mse_m2"], 2), ""),
        "accuracy.shadow.throttle.range": Cell("throttle", paper["throttle"], worded(paper["throttle"], 2, True), ""),
        "accuracy.shadow.steering.range": Cell("steering", paper["steering"], worded(paper["steering"], 2, True), ""),
    }
    return tuple(known.get(column.key, Cell(column.label, None, NONE, "")) for column in MAIN)


@dataclass(frozen=True, slots=True)
class Order:
    """The order in which the run was asked for its scenarios, weathers and drivers; colours follow the drivers'."""

    scenarios: tuple[str, ...]
    weathers: tuple[str, ...]
    drivers: tuple[str, ...]

    def place(self, row: Row) -> tuple[int, int, int]:
        """Where a row or a record stands."""
        return (
            self.scenarios.index(row["scenario"]),
            self.weathers.index(row["weather"]),
            self.drivers.index(row["driver"]),
        )

    def style(self, driver: str) -> str:
        """The class of a driver's colour; eight of them, then they come again."""
        return f"d{self.drivers.index(driver) % 8}"

    def cells(self) -> Iterator[tuple[str, str]]:
        """Each scenario in each weather."""
        return ((scenario, weather) for scenario in self.scenarios for weather in self.weathers)
