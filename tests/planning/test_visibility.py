"""Speed by what can be seen: a stop within it, from any speed that is allowed."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from driver_settings import ROBUST, unwrap

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.visibility import SpeedInSight, speed_within_clear_distance, stopping_speed
from vpf_sim.types import UNLIMITED, Camera, LowObstacleRange, RoadEdges, VehicleModel

VISIBILITY = unwrap(ROBUST.visibility)
CONFIG = replace(VISIBILITY.clear_distance, brake_mps2=3.0)
CAR = VehicleModel()
BUMPER_M = 0.5 * CAR.length_m


def driver_setup(speed_mps: float = 5.55) -> DriverSetup:
    return DriverSetup(Camera(), CAR, 60.0, speed_mps, (1e3, 0.0), 0)


@pytest.mark.parametrize("way_m", [0.0, 2.0, 8.0, 40.0])
def test_the_car_stops_within_the_way(way_m: float) -> None:
    speed = stopping_speed(way_m, CONFIG.brake_mps2, CONFIG.reaction_s)
    assert speed * CONFIG.reaction_s + speed**2 / (2.0 * CONFIG.brake_mps2) == pytest.approx(way_m)


def safe_speed(sight_m: float) -> float:
    """From which the car stops before what comes into sight."""
    return stopping_speed(sight_m - BUMPER_M - CONFIG.standoff_m, CONFIG.brake_mps2, CONFIG.reaction_s)


def slowed(speed_mps: float, now_m: float, good_m: float, wanted_mps: float = 5.55) -> float:
    sight_m = LowObstacleRange(now_m, good_m)
    return min(speed_mps, speed_within_clear_distance(sight_m, CONFIG, driver_setup(wanted_mps)))


@pytest.mark.parametrize("wanted_mps", [3.0, 5.55, 15.0])
def test_a_car_that_sees_all_that_can_be_seen_goes_as_fast_as_asked(wanted_mps: float) -> None:
    assert slowed(wanted_mps, 10.0, 10.0, wanted_mps) == wanted_mps


@pytest.mark.parametrize("wanted_mps", [4.5, 5.55])
def test_a_car_that_sees_less_goes_as_fast_as_the_stop_allows(wanted_mps: float) -> None:
    assert slowed(wanted_mps, 7.0, 10.0, wanted_mps) == pytest.approx(safe_speed(7.0))


def test_to_see_farther_than_a_stop_takes_is_no_reason_to_be_slowed_when_that_ends() -> None:
    assert slowed(4.5, 8.0, 10.0, 4.5) == 4.5


def test_where_a_good_view_is_not_enough_either_both_are_compared() -> None:
    share = safe_speed(8.0) / safe_speed(10.0)
    assert slowed(6.5, 8.0, 10.0, 6.5) == pytest.approx(share * 6.5)


def test_a_car_that_asks_for_more_than_a_good_view_allows_is_not_slowed_by_a_bad_one() -> None:
    assert slowed(15.0, 7.0, 10.0, wanted_mps=15.0) == 15.0


def test_the_reference_is_slowed_only() -> None:
    assert slowed(5.55, 0.0, 10.0) == CONFIG.cautious_mps
    assert slowed(0.0, 0.0, 10.0) == 0.0
    assert slowed(3.0, 0.0, 10.0, wanted_mps=3.0) == CONFIG.cautious_mps


@pytest.mark.parametrize("good_m", [0.0, np.inf])
def test_what_cannot_be_seen_at_that_speed_or_is_not_judged_slows_no_car(good_m: float) -> None:
    assert slowed(15.0, good_m, good_m, wanted_mps=15.0) == 15.0


def test_without_a_road_the_car_goes_slowly_and_stops_after_some_way() -> None:
    """A step takes it 0.5 m; when the road is seen again, the way counts anew."""
    in_sight, seen, lost = SpeedInSight(VISIBILITY, driver_setup()), road_seen(1.0), road_seen(0.0)
    steps = round(VISIBILITY.lost_road_m / 0.5)
    assert in_sight.limit(seen, 0.5) == np.inf
    assert [in_sight.limit(lost, 0.5) for _ in range(steps + 1)] == [VISIBILITY.lost_road_mps] * (steps - 1) + [0.0] * 2
    assert in_sight.limit(seen, 0.5) == np.inf
    assert in_sight.limit(lost, 0.5) == VISIBILITY.lost_road_mps


def road_seen(confidence: float) -> Any:
    """A perception with a good view of low obstacles."""
    return SimpleNamespace(road=RoadEdges(-7.0, 7.0, 0.0, 0.0, 0.1, confidence, 0.0, 3.5), low_range_m=UNLIMITED)
