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


@pytest.mark.parametrize(
    ("wanted_mps", "now_m", "good_m", "expected_mps"),
    [
        pytest.param(3.0, 10.0, 10.0, 3.0, id="a good view, slow"),
        pytest.param(15.0, 10.0, 10.0, 15.0, id="a good view, fast"),
        pytest.param(4.5, 7.0, 10.0, safe_speed(7.0), id="as fast as the stop allows"),
        pytest.param(5.55, 7.0, 10.0, safe_speed(7.0), id="as fast as the stop allows, faster asked"),
        pytest.param(4.5, 8.0, 10.0, 4.5, id="farther than a stop takes"),
        pytest.param(6.5, 8.0, 10.0, safe_speed(8.0) / safe_speed(10.0) * 6.5, id="a good view is not enough either"),
        pytest.param(15.0, 7.0, 10.0, 15.0, id="more than a good view allows"),
        pytest.param(5.55, 0.0, 10.0, CONFIG.cautious_mps, id="cautious where nothing is seen"),
        pytest.param(15.0, 0.0, 0.0, 15.0, id="not to be seen at that speed"),
        pytest.param(15.0, np.inf, np.inf, 15.0, id="not judged"),
    ],
)
def test_the_reference_is_slowed_by_what_is_seen_less_than_in_a_good_view(
    wanted_mps: float, now_m: float, good_m: float, expected_mps: float
) -> None:
    limit_mps = speed_within_clear_distance(LowObstacleRange(now_m, good_m), CONFIG, driver_setup(wanted_mps))
    assert min(wanted_mps, limit_mps) == pytest.approx(expected_mps)


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
