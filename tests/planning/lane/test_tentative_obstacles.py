"""Speed before what is tentative: a stop would be possible, nothing jerks, and what is not in the way slows nobody."""

from dataclasses import fields, replace

import numpy as np
import pytest
from lane_planner import ROBUST, unwrap

from vpf_sim.planning.lane.frame import NOTHING, Lane, LaneObstacles
from vpf_sim.planning.lane.speed.tentative_obstacles import TentativeLimit
from vpf_sim.types import VehicleModel

CONFIG = unwrap(ROBUST.tentative_obstacles)
VEHICLE = VehicleModel()
REFERENCE_MPS, RATE_HZ = 5.55, 60.0
LANE = Lane(0.0, 5.25, -8.75, 0.0, 0.0)


def suspect(gap_m: float, y_m: float = 0.0) -> LaneObstacles:
    return LaneObstacles(np.array([gap_m + 0.5 * VEHICLE.length_m]), np.array([y_m - 0.4]), np.array([y_m + 0.4]))


def driven(
    what: LaneObstacles, seconds: float = 3.0, goal_m: float = 0.0, caution: TentativeLimit | None = None
) -> list[float]:
    """Speeds of a car that follows exactly."""
    caution = caution or TentativeLimit(CONFIG, VEHICLE, REFERENCE_MPS, RATE_HZ)
    speeds = [REFERENCE_MPS]
    for _ in range(round(seconds * RATE_HZ)):
        speeds.append(caution.update(LANE, what, goal_m, speeds[-1]))
    return speeds[1:]


@pytest.mark.parametrize("gap_m", [5.5, 7.0, 8.5])
def test_the_car_could_stop_before_what_is_tentative(gap_m: float) -> None:
    speed = driven(suspect(gap_m))[-1]
    way = speed * CONFIG.reaction_s + speed**2 / (2.0 * CONFIG.brake_mps2)
    assert way + CONFIG.standoff_m == pytest.approx(gap_m)


def test_it_never_stops_for_a_tentative_obstacle() -> None:
    assert driven(suspect(1.0))[-1] == CONFIG.least_mps


@pytest.mark.parametrize("what", [NOTHING, suspect(20.0), suspect(-1.0), suspect(6.0, 2.0), suspect(6.0, -2.0)])
def test_what_is_far_or_beside_or_passed_slows_no_car(what: LaneObstacles) -> None:
    assert set(driven(what)) == {REFERENCE_MPS}


def test_what_lies_where_the_car_is_going_counts() -> None:
    assert driven(suspect(6.0, 2.0), goal_m=1.5)[-1] < 0.8 * REFERENCE_MPS


def test_the_speed_falls_as_the_car_brakes_and_rises_gently() -> None:
    caution = TentativeLimit(CONFIG, VEHICLE, REFERENCE_MPS, RATE_HZ)
    speeds = [REFERENCE_MPS, *driven(suspect(4.0), 1.5, caution=caution)]
    fall = -np.diff(speeds).min() * RATE_HZ
    assert fall == pytest.approx(CONFIG.brake_mps2)
    after = [speeds[-1], *driven(NOTHING, 3.0, caution=caution)]
    assert np.diff(after).max() * RATE_HZ == pytest.approx(CONFIG.rise_mps2)
    assert after[-1] == REFERENCE_MPS


def test_a_sight_that_fails_for_a_moment_does_not_jerk() -> None:
    caution = TentativeLimit(CONFIG, VEHICLE, REFERENCE_MPS, RATE_HZ)
    seen = [4.0, *[2.8] * 6, *[4.0] * 30]
    speeds = [caution.update(LANE, NOTHING, 0.0, 4.0, mps) for mps in [4.0] * 60 + seen]
    assert speeds[59] == 4.0
    assert speeds[66] == pytest.approx(4.0 - 6.0 * CONFIG.brake_mps2 / RATE_HZ)
    assert speeds[-1] == 4.0


def test_a_car_that_is_slow_already_is_not_slowed_later() -> None:
    caution = TentativeLimit(CONFIG, VEHICLE, REFERENCE_MPS, RATE_HZ)
    assert caution.update(LANE, suspect(5.0), 0.0, 3.5) == pytest.approx(3.5 - CONFIG.brake_mps2 / RATE_HZ)


@pytest.mark.parametrize("name", [one.name for one in fields(CONFIG)])
def test_nonsense_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name}: expected > 0, got 0"):
        replace(CONFIG, **{name: 0.0})
