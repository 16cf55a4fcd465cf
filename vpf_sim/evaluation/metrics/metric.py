"""A measure of an episode, and how a metric is shown."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from vpf_sim.evaluation.metrics import tracking
from vpf_sim.evaluation.score_keys import Number
from vpf_sim.evaluation.steps import Outcome, StepTable
from vpf_sim.types import Floats

Over = Literal["successes", "driven", "nothing"]


@dataclass(frozen=True)
class Driven:
    """An episode of at least one step on its route."""

    outcome: Outcome
    route: Floats  # (M, 2) waypoints from the start to beyond the goal
    route_length_m: float  # to the goal

    @property
    def table(self) -> StepTable:
        return self.outcome.steps

    @property
    def hits(self) -> list[str]:
        """The kinds of the objects that the car hit: an episode ends at the first."""
        return [self.outcome.collided_with] if self.outcome.collided_with else []

    @cached_property
    def reference(self) -> Floats:
        """(N, 2) the route up to the goal."""
        return tracking.shorten(self.route, self.route_length_m)

    @cached_property
    def completion(self) -> float:
        """Share of the route that was driven, 0 to 1."""
        is_whole = self.outcome.status == "success"
        return 1.0 if is_whole else tracking.completion(self.table.route_m, self.route_length_m)


@dataclass(frozen=True, slots=True)
class Measure:
    """A score of a record, or a table of scores, and the function that measures it.

    Its mean is over the successful episodes, over all driven ones, or is not computed.
    """

    key: str
    of: Callable[[Driven], object] | None = None  # None for a score within a table, or of a cell alone
    over: Over = "successes"
    unmeasured: Number = None  # of an episode that never began


@dataclass(frozen=True, slots=True)
class Metric(Measure):
    """A score with its name, unit and format; the key of one within a table is dotted."""

    title: str = ""
    unit: str = ""  # "%" for a share
    digits: int = 2
    better: Literal["more", "less"] = "more"
    perfect: float | None = None  # the best value, where there is one
    in_cell: str = ""  # key of its value in a cell's row, if it is not the mean at `key`
    of_perception: bool = False  # of what a driver perceives, not how it drives: shown of drives that did not arrive
    rule: str = ""  # name of the gate's rules for it
    paper: str = ""  # name in the paper's table
    tables: tuple[str, ...] = ()  # in which it is a column

    @property
    def row_key(self) -> str:
        """The key in a cell's row."""
        return self.in_cell or self.key

    @property
    def plain_unit(self) -> str:
        """The unit behind a value in plain letters, " m2"; empty for a share."""
        return "" if self.percent or not self.unit else f" {self.unit.replace('²', '2')}"

    @property
    def percent(self) -> bool:
        return self.unit == "%"

    @property
    def sign(self) -> int:
        """1 where more is better, else -1."""
        return 1 if self.better == "more" else -1

    @property
    def heading(self) -> str:
        """Title and unit: "path MSE, m²"."""
        return f"{self.title}, {self.unit}" if self.unit else self.title
