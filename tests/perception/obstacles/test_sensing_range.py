"""Sensing range of low obstacles, by observations that fail or succeed at known places."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import static_obstacles

from vpf_sim.perception.obstacles.planar_parallax.sensing_range import SensingRange

CONFIG = static_obstacles().planar_parallax.sensing_range
NEAR_M, PERIOD_S, SIGHTINGS = 6.5, 0.1, 2
GRAIN = 3.0


def range_m(noise: float, seen: float = 1.0, speed_mps: float = 5.0, looks: int = 200, grain: float = GRAIN) -> float:
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    for _ in range(looks):
        sight.record(noise, grain, np.full(len(sight.forward_m), seen))
    return sight.distance_m(speed_mps, SIGHTINGS)


def difference(forward_m: float) -> float:
    """Of a low obstacle, by its definition."""
    return CONFIG.grains * GRAIN * (CONFIG.grains_at_m / forward_m) ** CONFIG.power


def test_in_clear_air_only_the_way_of_the_observations_is_lost() -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    assert range_m(noise=1.0) == pytest.approx(CONFIG.far_m - way, abs=0.25)


@pytest.mark.parametrize("forward_m", [9.0, 10.0, 11.0])
def test_noise_limits_the_range_by_the_difference_of_an_obstacle(forward_m: float) -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    assert range_m(noise=difference(forward_m)) == pytest.approx(forward_m - way, abs=0.253)


def test_water_on_half_of_the_road_takes_twice_the_way() -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    assert range_m(noise=1.0, seen=0.5) == pytest.approx(CONFIG.far_m - 2.0 * way, abs=0.25)


def test_a_slower_car_has_a_longer_range() -> None:
    far = [range_m(noise=1.0, speed_mps=speed) for speed in (0.0, 1.0, 3.0, 5.0, 8.0)]
    assert far == sorted(far, reverse=True)
    assert far[0] == pytest.approx(CONFIG.far_m, abs=0.25)


def test_haze_takes_contrast_from_grain_and_obstacle_alike() -> None:
    assert range_m(noise=100.0, grain=2.0) == range_m(noise=50.0, grain=1.0) == range_m(noise=200.0, grain=4.0)


def test_without_grain_or_dry_road_the_range_is_zero() -> None:
    assert range_m(noise=10.0, grain=0.0) == 0.0
    assert range_m(noise=10.0, seen=0.0) == 0.0


def test_before_the_first_observation_the_view_counts_as_good() -> None:
    assert range_m(noise=np.inf, looks=0) == range_m(noise=1.0)


def test_the_range_of_a_good_view_does_not_depend_on_the_observations() -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    for _ in range(50):
        sight.record(np.inf, GRAIN, np.zeros(len(sight.forward_m)))
    assert sight.distance_m(5.0, SIGHTINGS) == 0.0
    assert sight.good_m(5.0, SIGHTINGS) == pytest.approx(CONFIG.far_m - way / CONFIG.good_share, abs=0.25)
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
