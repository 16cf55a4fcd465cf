"""Speed before what is tentative: a stop would be possible, nothing jerks, and what is not in the way slows nobody."""

import numpy as np
import pytest
from lane_planner import BRAKING, BUMPER_M, RATE_HZ, ROBUST, SETUP, unwrap
from lane_planner import SPEED_MPS as REFERENCE_MPS

from vpf_sim.planning.lane.frame import NOTHING, Lane, LaneObstacles
from vpf_sim.planning.lane.speed.tentative_obstacles import TentativeLimit

LANE = Lane(0.0, 5.25, -8.75, 0.0, 0.0)


def limit() -> TentativeLimit:
    return TentativeLimit(unwrap(ROBUST.tentative_m), BRAKING, SETUP)


def tentative(gap_m: float, y_m: float = 0.0) -> LaneObstacles:
    return LaneObstacles(np.array([gap_m + BUMPER_M]), np.array([y_m - 0.4]), np.array([y_m + 0.4]))


def driven(
    what: LaneObstacles, seconds: float = 3.0, goal_m: float = 0.0, caution: TentativeLimit | None = None
) -> list[float]:
    """Speeds of a car that follows exactly."""
    caution = caution or limit()
    speeds = [REFERENCE_MPS]
    for _ in range(round(seconds * RATE_HZ)):
        speeds.append(caution.update(LANE, what, goal_m, speeds[-1]))
    return speeds[1:]


@pytest.mark.parametrize("gap_m", [5.5, 7.0, 8.5])
def test_the_car_could_stop_before_what_is_tentative(gap_m: float) -> None:
    speed = driven(tentative(gap_m))[-1]
    way = speed * BRAKING.reaction_s + speed**2 / (2.0 * BRAKING.emergency_mps2)
    assert way + BRAKING.standoff_m == pytest.approx(gap_m)


def test_it_never_stops_for_a_tentative_obstacle() -> None:
    assert driven(tentative(1.0))[-1] == BRAKING.cautious_mps


@pytest.mark.parametrize("what", [NOTHING, tentative(20.0), tentative(-1.0), tentative(6.0, 2.0), tentative(6.0, -2.0)])
def test_what_is_far_or_beside_or_passed_slows_no_car(what: LaneObstacles) -> None:
    assert set(driven(what)) == {REFERENCE_MPS}


def test_what_lies_where_the_car_is_going_counts() -> None:
    assert driven(tentative(6.0, 2.0), goal_m=1.5)[-1] < 0.8 * REFERENCE_MPS


def test_the_speed_falls_as_the_car_brakes_and_rises_gently() -> None:
    caution = limit()
    speeds = [REFERENCE_MPS, *driven(tentative(4.0), 1.5, caution=caution)]
    fall = -np.diff(speeds).min() * RATE_HZ
    assert fall == pytest.approx(BRAKING.emergency_mps2)
    after = [speeds[-1], *driven(NOTHING, 3.0, caution=caution)]
    assert np.diff(after).max() * RATE_HZ == pytest.approx(BRAKING.rise_mps2)
    assert after[-1] == REFERENCE_MPS


def test_a_sight_that_fails_for_a_moment_does_not_jerk() -> None:
    caution = limit()
    seen = [4.0, *[2.8] * 6, *[4.0] * 30]
    speeds = [caution.update(LANE, NOTHING, 0.0, 4.0, mps) for mps in [4.0] * 60 + seen]
    assert speeds[59] == 4.0
    assert speeds[66] == pytest.approx(4.0 - 6.0 * BRAKING.emergency_mps2 / RATE_HZ)
    assert speeds[-1] == 4.0


def test_a_car_that_is_slow_already_is_not_slowed_later() -> None:
    caution = limit()
    assert caution.update(LANE, tentative(5.0), 0.0, 3.5) == pytest.approx(3.5 - BRAKING.emergency_mps2 / RATE_HZ)
