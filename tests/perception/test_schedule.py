"""Periods in seconds become whole frames at any frame rate."""

from itertools import pairwise

import pytest

from vpf_sim.perception.schedule import Schedule


@pytest.mark.parametrize("rate_hz", [10.0, 20.0, 25.0, 30.0, 60.0])
@pytest.mark.parametrize("period_s", [0.05, 0.2, 0.5])
def test_work_is_done_within_half_a_frame_of_its_period(period_s: float, rate_hz: float) -> None:
    schedule = Schedule(period_s, rate_hz)
    due_s = [frame / rate_hz for frame in range(200) if schedule.step()]
    assert due_s[0] == 0.0
    gaps = [later - sooner for sooner, later in pairwise(due_s)]
    wanted = max(period_s, 1.0 / rate_hz)
    assert all(abs(gap - wanted) <= 0.5 / rate_hz + 1e-9 for gap in gaps)


@pytest.mark.parametrize(
    ("rate_hz", "every"), [(60.0, 3), (50.0, 2), (30.0, 1), (29.97, 1), (24.0, 1), (20.0, 1), (10.0, 1)]
)
def test_at_least_as_often_never_waits_longer_than_the_period(rate_hz: float, every: int) -> None:
    schedule = Schedule(0.05, rate_hz, at_least_as_often=True)
    assert schedule.rate_hz == pytest.approx(rate_hz / every)
    assert schedule.rate_hz == rate_hz or 1.0 / schedule.rate_hz <= 0.05 + 1e-6


def test_the_next_frame_can_be_asked_for_without_taking_it() -> None:
    schedule = Schedule(0.1, 20.0)
    due = []
    for _ in range(6):
        due.append(schedule.is_due)
        assert schedule.is_due == due[-1]
        assert schedule.step() == due[-1]
    assert due == [True, False] * 3
