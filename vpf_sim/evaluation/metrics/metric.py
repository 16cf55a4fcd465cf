"""A measure of an episode, and how a metric is shown."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from vpf_sim.evaluation.metrics.driven import Driven
from vpf_sim.evaluation.scores import Number

Over = Literal["successes", "driven", "nothing"]


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
    drivers: Literal["all", "all but the PID", "perceiving"] = "all"  # the others have no value
    rule: str = ""  # name of the gate's rules for it
    paper: str = ""  # name in the paper's table
    tables: tuple[str, ...] = ()  # in which it is a column

    @property
    def row_key(self) -> str:
        """The key in a cell's row."""
        return self.in_cell or self.key

    @property
    def rates_lost(self) -> bool:
        """Whether it is shown of drives that did not arrive: what they perceived, not how they drove."""
        return self.drivers == "perceiving"

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
