"""Sensing range of low obstacles, by observations that fail or succeed at known places."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import static_obstacles

from vpf_sim.perception.obstacles.planar_parallax.sensing_range import SensingRange

CONFIG = static_obstacles().planar_parallax.sensing_range
NEAR_M, PERIOD_S, SIGHTINGS = 6.5, 0.1, 2
GRAIN = 3.0
WAY_M = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0  # of the observations


def range_m(noise: float, seen: float = 1.0, speed_mps: float = 5.0, looks: int = 200, grain: float = GRAIN) -> float:
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    for _ in range(looks):
        sight.record(noise, grain, np.full(len(sight.forward_m), seen))
    return sight.distance_m(speed_mps, SIGHTINGS)


def difference(forward_m: float) -> float:
    """Of a low obstacle, by its definition."""
    return CONFIG.grains * GRAIN * (CONFIG.grains_at_m / forward_m) ** CONFIG.power


@pytest.mark.parametrize(
    ("noise", "seen", "expected_m"),
    [
        pytest.param(1.0, 1.0, CONFIG.far_m - WAY_M, id="clear air: only the way of the observations is lost"),
        pytest.param(difference(9.0), 1.0, 9.0 - WAY_M, id="noise as an obstacle at 9 m"),
        pytest.param(difference(11.0), 1.0, 11.0 - WAY_M, id="noise as an obstacle at 11 m"),
        pytest.param(1.0, 0.5, CONFIG.far_m - 2.0 * WAY_M, id="water on half of the road: twice the way"),
    ],
)
def test_noise_and_water_limit_the_range(noise: float, seen: float, expected_m: float) -> None:
    assert range_m(noise, seen) == pytest.approx(expected_m, abs=0.253)


def test_a_slower_car_has_a_longer_range() -> None:
    far = [range_m(noise=1.0, speed_mps=speed) for speed in (0.0, 1.0, 3.0, 5.0, 8.0)]
    assert far == sorted(far, reverse=True)
    assert far[0] == pytest.approx(CONFIG.far_m, abs=0.25)


def test_haze_takes_contrast_from_grain_and_obstacle_alike() -> None:
    assert range_m(noise=50.0, grain=2.0) == range_m(noise=25.0, grain=1.0) == range_m(noise=100.0, grain=4.0) > NEAR_M


def test_without_grain_or_dry_road_the_range_is_zero() -> None:
    assert range_m(noise=10.0, grain=0.0) == 0.0
    assert range_m(noise=10.0, seen=0.0) == 0.0


def test_before_the_first_observation_the_view_counts_as_good() -> None:
    assert range_m(noise=np.inf, looks=0) == range_m(noise=1.0)


def test_the_range_of_a_good_view_does_not_depend_on_the_observations() -> None:
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    for _ in range(50):
        sight.record(np.inf, GRAIN, np.zeros(len(sight.forward_m)))
    assert sight.distance_m(5.0, SIGHTINGS) == 0.0
    assert sight.good_m(5.0, SIGHTINGS) == pytest.approx(CONFIG.far_m - WAY_M / CONFIG.good_share, abs=0.25)
    assert sight.good_m(20.0, SIGHTINGS) == 0.0, "too fast for any"


def test_one_bad_observation_costs_little_range() -> None:
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    whole = np.ones(len(sight.forward_m))
    for noise in (1.0, 1.0, np.inf, 1.0):
        sight.record(noise, GRAIN, whole)
    assert sight.distance_m(5.0, SIGHTINGS) > range_m(noise=1.0) - 0.6


def test_a_wrong_setting_is_refused() -> None:
    with pytest.raises(ValueError, match="grains: expected > 0"):
        replace(CONFIG, grains=0.0)
