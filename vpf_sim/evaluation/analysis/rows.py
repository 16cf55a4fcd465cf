"""The summary of a run: a row for each cell (scenario, weather, driver), and differences between cells."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

from pydantic import Field, PositiveInt, SkipValidation

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.statistics import Difference, Interval
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.records import Schema, checked
from vpf_sim.evaluation.score_keys import Json, Number, flat, leaves, nested


class Cell(NamedTuple):
    scenario: str
    weather: str
    driver: str


class Row(Schema):
    """The results of a cell; scores are means over the successful episodes, with shares and totals of all."""

    scenario: str
    weather: str
    driver: str
    privileged: str = "none"
    episodes: PositiveInt
    successes: int
    statuses: dict[str, int]
    scores: SkipValidation[dict[str, Number]]  # by dotted key
    intervals: SkipValidation[dict[str, Interval | None]]  # 95 %, by the keys of scores
    unsuccessful: SkipValidation[dict[str, Number]]  # means over the other episodes
    seeds_needed: dict[str, int | None] = Field(default_factory=dict)
    paper: dict[str, float] | None = None  # printed values

    @property
    def cell(self) -> Cell:
        return Cell(self.scenario, self.weather, self.driver)

    @property
    def missing(self) -> int:
        """The number of planned episodes without a record."""
        return self.episodes - sum(self.statuses.values())

    def is_of_lost(self, metric: Metric) -> bool:
        """Whether the value of a metric is that of episodes that did not arrive, since none did."""
        return metric.of_perception and not self.successes

    def __getitem__(self, metric: Metric) -> Number:
        """The value of a metric; None where there is none, as of the path where no episode arrived.

        A short drive seems better than it is, so path and commands of one that did not arrive are not shown.
        """
        found = self.unsuccessful if self.is_of_lost(metric) else self.scores
        return found.get(metric.row_key)

    def interval(self, metric: Metric) -> Interval | None:
        """The 95 % interval of a value."""
        return self.intervals.get(metric.row_key)

    def as_json(self) -> Json:
        own = self.model_dump(exclude={"scores", "intervals", "unsuccessful"})
        ends = {key: ends and list(ends) for key, ends in self.intervals.items()}
        return {**own, **nested(self.scores), "intervals": nested(ends), "unsuccessful": nested(self.unsuccessful)}


class Comparison(NamedTuple):
    """The differences of the metrics of two cells, the first minus the second; None without pairs."""

    of: Literal["weather", "driver"]  # in which the cells differ
    cell: Cell
    minus: str
    differences: Mapping[str, Difference | None]  # by dotted key

    @property
    def other(self) -> Cell:
        """The cell that is subtracted."""
        return self.cell._replace(**{self.of: self.minus})

    def as_json(self) -> Json:
        found = {key: one and as_json(one) for key, one in self.differences.items()}
        return {"of": self.of, **self.cell._asdict(), "minus": self.minus, **found}


class Summary(NamedTuple):
    """The rows and comparisons of a run."""

    rows: tuple[Row, ...]
    comparisons: tuple[Comparison, ...]

    def has_cells(self, cells: set[Cell]) -> bool:
        """Whether the rows are those of the cells, and all comparisons are between them."""
        compared = {cell for one in self.comparisons for cell in (one.cell, one.other)}
        return {row.cell for row in self.rows} == cells and compared <= cells

    def as_json(self) -> Json:
        """The content of summary.json."""
        return {
            "rows": [row.as_json() for row in self.rows],
            "comparisons": [one.as_json() for one in self.comparisons],
        }


def as_json(found: Difference) -> Json:
    return {**found._asdict(), "interval": found.interval and list(found.interval)}


_OWN = Row.model_fields.keys() - {"scores", "intervals", "unsuccessful"}
_TABLES = ("intervals", "unsuccessful")


class _Stored(Schema):
    rows: list[Json]
    comparisons: list[Json] = Field(default_factory=list)


class _Difference(Schema):
    difference: float
    interval: list[float] | None
    p: float
    pairs: int


class _Cells(Schema):
    of: Literal["weather", "driver"]
    scenario: str
    weather: str
    driver: str
    minus: str


def read_summary(content: Json, where: str) -> Summary:
    """The summary of a file's content; InputError in one line where it is none."""
    stored = checked(_Stored, content, where)
    rows = [_row(row, f"{where}: rows.{i}") for i, row in enumerate(stored.rows)]
    found = [_comparison(one, f"{where}: comparisons.{i}") for i, one in enumerate(stored.comparisons)]
    return Summary(tuple(rows), tuple(found))


def _row(row: Json, where: str) -> Row:
    own = {key: row[key] for key in row.keys() & _OWN}
    scores = {key: row[key] for key in row.keys() - _OWN - {*_TABLES}}
    try:
        ends = {key: _ends(key, value) for key, value in leaves(_table(row, "intervals"))}
        unsuccessful = flat(_table(row, "unsuccessful"))
        values = {"scores": flat(scores), "intervals": ends, "unsuccessful": unsuccessful}
    except ValueError as error:
        raise InputError(f"{where}.{error}") from None
    return checked(Row, {**own, **values}, where)


def _table(row: Json, key: str) -> Json:
    value = row.get(key) or {}
    if not isinstance(value, dict):
        raise ValueError(f"{key}: expected a table, got {value!r}")
    return value


def _ends(key: str, value: object) -> Interval | None:
    if isinstance(value, list) and len(value) == 2 and all(isinstance(end, int | float) for end in value):
        return Interval(*value)
    if value is None or value == {}:
        return None
    raise ValueError(f"intervals.{key}: expected two numbers for each interval, got {value!r}")


def _comparison(row: Json, where: str) -> Comparison:
    of = checked(_Cells, row, where)
    differences: dict[str, Difference | None] = {}
    for key in row.keys() - _Cells.model_fields.keys():
        value = row[key]
        if value is not None and not isinstance(value, dict):
            raise InputError(f"{where}.{key}: expected a difference, got {value!r}")
        differences[key] = None if value is None else _difference(value, f"{where}.{key}")
    return Comparison(of.of, Cell(of.scenario, of.weather, of.driver), of.minus, differences)


def _difference(value: Json, where: str) -> Difference:
    found = checked(_Difference, value, where)
    ends = found.interval
    if ends is not None and len(ends) != 2:
        raise InputError(f"{where}.interval: expected two numbers, got {ends!r}")
    return Difference(found.difference, None if ends is None else Interval(*ends), found.p, found.pairs)
