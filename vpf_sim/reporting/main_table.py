"""The main table of a report, its cells, and the order of scenarios, weathers and drivers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Protocol

from vpf_sim.evaluation.analysis.rows import Row
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.registry import SUCCESS, columns
from vpf_sim.reporting.kit.page import Value, formatted, interval_text

DRIVING = columns("driving")


@dataclass(frozen=True, slots=True)
class DriverRow:
    """One driver's results in one scenario and weather."""

    driver: str
    privileged: str
    successes: int
    episodes: int
    interval: str  # of the success rate, formatted
    endings: str  # of the unsuccessful episodes, as text
    cells: tuple[Value, ...]


@dataclass(frozen=True, slots=True)
class Group:
    """The rows of one scenario and weather, with the paper's values."""

    scenario: str
    weather: str
    paper: tuple[Value, ...]
    rows: tuple[DriverRow, ...]


def shown(name: str) -> str:
    """The display name of a scenario or weather: a file's name without its folder."""
    return Path(name).stem if name.endswith(".toml") else name


def text_of(metric: Metric, value: float | None) -> str:
    """A value of a metric, formatted without its unit."""
    return formatted(value, metric.digits, metric.percent)


def ends_of(metric: Metric, row: Row) -> str:
    """The interval of a metric, formatted; empty without one."""
    return interval_text(row.interval(metric), metric.digits, metric.percent)


def cell(row: Row, metric: Metric) -> Value:
    """The cell of a metric, with its interval."""
    value = row[metric]
    return Value(text_of(metric, value), ends_of(metric, row), value)


def groups(rows: Sequence[Row], order: "Order") -> list[Group]:
    """The main table, grouped by scenario and weather."""
    return [
        Group(shown(scenario), shown(weather), _paper(found := list(group)), tuple(driver_row(row) for row in found))
        for (scenario, weather), group in groupby(order.sorted(rows), key=lambda row: (row.scenario, row.weather))
    ]


def driver_row(row: Row) -> DriverRow:
    """The main table's row of a driver."""
    cells = tuple(cell(row, metric) for metric in DRIVING)
    return DriverRow(
        row.driver, row.privileged, row.successes, row.episodes, ends_of(SUCCESS, row), endings(row), cells
    )


def endings(row: Row) -> str:
    """How the unsuccessful episodes ended: "3 collision, 1 off road"."""
    counts = [
        f"{count} {status.replace('_', ' ')}" for status, count in sorted(row.statuses.items()) if status != "success"
    ]
    return ", ".join([*counts, *([f"{row.missing} not driven"] if row.missing else [])])


def _paper(rows: Sequence[Row]) -> tuple[Value, ...]:
    """The paper's row in the main table's columns; empty if it has none."""
    paper = rows[0].paper
    if not paper:
        return ()
    values = [(metric, paper.get(metric.paper)) for metric in DRIVING]
    return tuple(Value(formatted(value, 2, metric.percent), value=value) for metric, value in values)


class Placed(Protocol):
    """Of a cell: a row, a record, a comparison."""

    @property
    def cell(self) -> tuple[str, str, str]: ...


@dataclass(frozen=True, slots=True)
class Order:
    """The order of scenarios, weathers and drivers in the plan; it also gives the drivers' colours."""

    scenarios: tuple[str, ...]
    weathers: tuple[str, ...]
    drivers: tuple[str, ...]

    def place(self, one: Placed) -> tuple[int, int, int]:
        """The sort key of what belongs to a cell."""
        scenario, weather, driver = one.cell
        return self.scenarios.index(scenario), self.weathers.index(weather), self.drivers.index(driver)

    def sorted(self, rows: Sequence[Row]) -> list[Row]:
        """Rows in this order."""
        return sorted(rows, key=self.place)

    def style(self, driver: str) -> str:
        """The CSS class of a driver's colour, one of eight."""
        return f"d{self.drivers.index(driver) % 8}"

    def cells(self) -> Iterator[tuple[str, str]]:
        """Every pair of scenario and weather."""
        return ((scenario, weather) for scenario in self.scenarios for weather in self.weathers)
