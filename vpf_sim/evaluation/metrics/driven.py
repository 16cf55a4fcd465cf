"""What metrics are functions of."""

from dataclasses import dataclass
from functools import cached_property

from vpf_sim.evaluation.metrics import path
from vpf_sim.evaluation.outcome import Outcome
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.types import Floats


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
        return path.shorten(self.route, self.route_length_m)

    @cached_property
    def completion(self) -> float:
        """Share of the route that was driven, 0 to 1."""
        is_whole = self.outcome.status == "success"
        return 1.0 if is_whole else path.completion(self.table.route_m, self.route_length_m)
