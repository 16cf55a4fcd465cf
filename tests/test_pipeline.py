"""A pipeline runs its stages on one state, and refuses lists that cannot work."""

from dataclasses import dataclass

import pytest

from vpf_sim.pipeline import Pipeline, stage
from vpf_sim.timing import Stopwatch


@dataclass(slots=True)
class Sums:
    number: float = 0.0
    double: float = 0.0
    half: float = 0.0
    total: float = 0.0


def halves(number: float) -> tuple[float, float]:
    return 2.0 * number, 0.5 * number


STAGES = (
    stage("halves", halves, "number", "double half"),
    stage("sum", lambda half, total: total + half, "half total", "total"),
)


def test_stages_hand_on_named_fields_and_feedback_stays() -> None:
    pipeline, state = Pipeline(Sums, STAGES, "number", "total"), Sums()
    for number in (4.0, 6.0):
        state.number = number
        pipeline.run(state)
    assert state == Sums(6.0, 12.0, 3.0, 5.0)


def test_each_stage_is_timed_under_its_name() -> None:
    watch, state = Stopwatch(), Sums(4.0)
    with watch.running():
        Pipeline(Sums, STAGES, "number", "total").run(state)
    watch.end_step()
    assert list(watch.medians_ms()) == ["halves", "sum"]


def test_a_field_that_the_state_lacks_is_refused() -> None:
    with pytest.raises(ValueError, match="stage halves: expected fields of Sums, got triple"):
        Pipeline(Sums, [stage("halves", halves, "number", "double triple")], "number", "")


def test_a_field_that_nothing_has_written_is_refused() -> None:
    with pytest.raises(ValueError, match="stage sum: expected total from an earlier stage, got none"):
        Pipeline(Sums, STAGES, "number", "")


def test_a_stage_that_gives_another_number_of_results_is_an_error() -> None:
    with pytest.raises(ValueError, match="zip"):
        Pipeline(Sums, [stage("one", lambda number: (number,), "number", "double half")], "number", "").run(Sums())
