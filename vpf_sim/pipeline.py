"""A pipeline: a list of named stages, each with the fields of one state that it reads and writes."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any, Generic, TypeVar

from vpf_sim.timing import call

State = TypeVar("State")


@dataclass(frozen=True, slots=True)
class Stage:
    """A function, the fields that are its arguments in their order, and the fields that take its result."""

    name: str
    function: Callable[..., Any]
    reads: tuple[str, ...]
    writes: tuple[str, ...] = ()


def stage(name: str, function: Callable[..., Any], reads: str, writes: str = "") -> Stage:
    """A stage; `reads` and `writes` list fields, separated by spaces."""
    return Stage(name, function, tuple(reads.split()), tuple(writes.split()))


class Pipeline(Generic[State]):
    """Runs its stages in their order on a state.

    `inputs` are the fields that are set before each run, `feedback` those that keep the value of the run before.
    ValueError where a stage names a field that the state does not have, or reads one that nothing has written before.
    """

    def __init__(self, state: type[State], stages: Iterable[Stage], inputs: str, feedback: str) -> None:
        self.stages: Sequence[Stage] = tuple(stages)
        known = {field.name for field in fields(state)}  # type: ignore[arg-type]
        ready = {*inputs.split(), *feedback.split()}
        for one in self.stages:
            for name in (*one.reads, *one.writes):
                if name not in known:
                    raise ValueError(f"stage {one.name}: expected fields of {state.__name__}, got {name}")
            for name in one.reads:
                if name not in ready:
                    raise ValueError(f"stage {one.name}: expected {name} from an earlier stage, got none")
            ready.update(one.writes)

    def run(self, state: State) -> None:
        """Run all stages; each is timed under its name."""
        for one in self.stages:
            result = call(one.name, one.function, *[getattr(state, name) for name in one.reads])
            if len(one.writes) == 1:
                setattr(state, one.writes[0], result)
            else:
                for name, value in zip(one.writes, result or (), strict=True):
                    setattr(state, name, value)
