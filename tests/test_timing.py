"""The stopwatch: which stages it times, and how it sums them up; never a time."""

import pytest

from vpf_sim import timing
from vpf_sim.timing import Stopwatch, call, timed


@timed("length")
def length(x: float, y: float) -> float:
    return (x * x + y * y) ** 0.5


class Clock:
    """Stands in for the clock: each reading is set."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(timing, "perf_counter", clock)
    return clock


def test_marked_stages_are_timed_while_the_stopwatch_runs_and_only_then(clock: Clock) -> None:
    def wait(ms: float) -> float:
        clock.now_s += 1e-3 * ms
        return ms

    watch = Stopwatch()
    call("before", wait, 5.0)
    with watch.running():
        assert call("stage", wait, 2.0) == 2.0
        assert call("stage", wait, 3.0) == 3.0
        assert length(3.0, 4.0) == 5.0
    call("after", wait, 5.0)
    watch.end_step()
    assert watch.medians_ms() == {"stage": pytest.approx(5.0), "length": 0.0}


def test_a_stage_that_raises_is_timed_and_the_error_passes(clock: Clock) -> None:
    def fail() -> None:
        clock.now_s += 1e-3
        raise ValueError("broken")

    watch = Stopwatch()
    with watch.running(), pytest.raises(ValueError, match="broken"):
        call("stage", fail)
    watch.end_step()
    assert watch.medians_ms() == {"stage": pytest.approx(1.0)}


def test_a_stage_of_some_steps_counts_by_its_share_and_a_disturbed_window_does_not(clock: Clock) -> None:
    watch = Stopwatch()
    for step in range(50):
        for name, ms in [("each", 1000.0 if step == 7 else 2.0), *([("third", 30.0)] if step % 5 == 0 else [])]:
            with watch.stage(name):
                clock.now_s += 1e-3 * ms
        watch.end_step()
    assert watch.typical_ms(10) == {"each": pytest.approx(2.0), "third": pytest.approx(6.0)}
    assert watch.medians_ms() == {"each": pytest.approx(2.0), "third": pytest.approx(30.0)}


def test_medians_are_over_the_steps_that_count() -> None:
    watch = Stopwatch()
    with watch.stage("a"):
        pass
    watch.skip_step()
    with watch.stage("b"):
        pass
    watch.end_step()
    watch.end_step()
    assert watch.medians_ms().keys() == {"b"}
