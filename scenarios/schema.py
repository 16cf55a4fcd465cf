"""The schema of a scenario file, and the draw of a seed."""

from collections.abc import Iterator
from typing import Annotated, Literal, TypeVar

from pydantic import Field

from vpf_sim.scenarios import checks
from vpf_sim.scenarios.parts import Ego, Exercise, Goal, Limits, ObjectSpec, Road, Section, Vary
from vpf_sim.seeding import stream

SectionT = TypeVar("SectionT", bound=Section)


class Scenario(Exercise):
    """A road, an ego car, a goal and objects (`bodies`); `draw` returns the scenario of a seed."""

    version: Literal[1] = Field(alias="schema")
    road: Road
    ego: Ego = Ego()
    goal: Goal
    bodies: Annotated[tuple[ObjectSpec, ...], Field(strict=False)] = ()
    limits: Limits | None = None
    vary: Vary = Field(default_factory=dict)

    def faults(self) -> Iterator[str]:
        """Every fault, for any seed."""
        return checks.faults(self.road, self.ego, self.goal, self.bodies, self.vary)

    @property
    def time_limit_s(self) -> float:
        """s, time limit; by default three times the route's duration at the reference speed."""
        if self.limits is not None:
            return self.limits.time_s
        return 3.0 * (self.goal.s_m - self.ego.s_m) / self.ego.speed_reference_mps

    def draw(self, seed: int) -> "Scenario":
        """The scenario of one seed; each varied value has its own random stream."""
        ego = drawn(self.ego, self.vary, "ego", "ego", seed)
        bodies = tuple(drawn(spec, self.vary, "bodies", f"bodies.{i}", seed) for i, spec in enumerate(self.bodies))
        return self.model_copy(update={"ego": ego, "bodies": bodies, "vary": {}})

    def without_objects(self) -> "Scenario":
        """The same road and start without objects."""
        return self.model_copy(update={"bodies": ()})


def drawn(part: SectionT, vary: Vary, group: str, name: str, seed: int) -> SectionT:
    """A section with uniform draws in [low, high] added to its varied values."""
    update = {}
    for key, (low, high) in vary.items():
        where, field = key.split(".")
        if where == group:
            update[field] = getattr(part, field) + float(stream(seed, f"{name}.{field}").uniform(low, high))
    return part.model_copy(update=update)
