"""Speed by votes of road points: a feasible path in spite of wrong windows."""

import numpy as np
import pytest

from vpf_sim.replay import road_speed
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

TIMES_S = np.arange(0.0, 20.0, 0.1)


def votes(speed_mps: Floats, wrong: dict[tuple[float, float], float] | None = None) -> list[tuple[float, Floats]]:
    """Twelve points a frame within 5 % of the truth, four random ones; in the window `wrong` all of another speed."""
    rng = stream(0, "votes")
    voted = []
    for time, speed in zip(TIMES_S, speed_mps, strict=True):
        for (start, stop), other in (wrong or {}).items():
            speed = other if start <= time < stop else speed
        near = speed * rng.normal(1.0, 0.05, 12)
        voted.append((float(time), np.column_stack([[*near, *rng.uniform(1.0, 60.0, 4)], np.ones(16)])))
    return voted


def steepest(speed_mps: Floats) -> float:
    return float(np.abs(np.gradient(speed_mps, TIMES_S)).max())


def test_constant_speed_is_found() -> None:
    assert road_speed.speed(TIMES_S, votes(np.full(200, 25.0))) == pytest.approx(np.full(200, 25.0), rel=0.03)


@pytest.mark.parametrize("wrong_mps", [57.0, 4.0])
def test_windows_with_another_speed_cause_no_jump(wrong_mps: float) -> None:
    found = road_speed.speed(TIMES_S, votes(np.full(200, 25.0), {(6.0, 8.0): wrong_mps, (12.0, 13.0): wrong_mps}))
    assert found == pytest.approx(np.full(200, 25.0), abs=2.5)
    assert steepest(found) < road_speed.MOST_LOSS_MPS2


def test_single_still_frame_does_not_stop_the_car() -> None:
    stands = np.zeros(200, np.bool_)
    stands[80:84] = True
    assert road_speed.speed(TIMES_S, votes(np.full(200, 25.0)), stands).min() > 20.0


def test_standing_start_is_followed() -> None:
    true = np.clip(2.0 * (TIMES_S - 5.0), 0.0, 14.0)
    voted = [
        (time, part if speed > 1.0 else part[:0]) for (time, part), speed in zip(votes(true + 1e-6), true, strict=True)
    ]
    found = road_speed.speed(TIMES_S, voted, true <= 0.0)
    assert found[TIMES_S < 4.5] == pytest.approx(np.zeros(np.count_nonzero(TIMES_S < 4.5)))
    assert np.abs(found - true).max() < 1.5
    assert steepest(found) < road_speed.MOST_GAIN_MPS2


def test_hard_braking_to_standstill_is_followed() -> None:
    true = np.clip(20.0 - 7.0 * (TIMES_S - 8.0), 0.0, 20.0)
    found = road_speed.speed(TIMES_S, votes(true + 1e-6), true <= 0.0)
    assert np.abs(found - true).max() < 3.0
    assert found[-50:] == pytest.approx(np.zeros(50))


def test_cut_in_the_video_may_change_the_speed() -> None:
    true = np.where(TIMES_S < 10.0, 30.0, 12.0)
    found = road_speed.speed(TIMES_S, votes(true))
    assert found[TIMES_S < 9.0] == pytest.approx(np.full(90, 30.0), rel=0.1)
    assert found[TIMES_S > 11.0] == pytest.approx(np.full(89, 12.0), rel=0.1)


def test_no_votes_give_no_speed() -> None:
    voted = votes(np.full(200, 25.0))
    gone = [(time, part[:0] if 8.0 <= time < 12.0 else part) for time, part in voted]
    found = road_speed.speed(TIMES_S, gone)
    assert np.isnan(found[(TIMES_S > 9.0) & (TIMES_S < 11.0)]).all()
    assert np.isfinite(found[TIMES_S < 8.0]).all()
    assert np.isnan(road_speed.speed(TIMES_S, [])).all()
