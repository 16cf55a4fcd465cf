"""How far a low body would be suspected: against looks that fail or hold at known places."""

import numpy as np
import pytest

from vpf_sim.perception.obstacles.planar_parallax.sensing_range import LookQuality, SensingRange, SensingRangeConfig

CONFIG = SensingRangeConfig()
NEAR_M, PERIOD_S, SIGHTINGS = 6.5, 0.1, 2
GRAIN = 3.0


def told(noise: float, seen: float = 1.0, speed_mps: float = 5.0, looks: int = 200, grain: float = GRAIN) -> float:
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    for _ in range(looks):
        sight.record(LookQuality(noise, grain, np.full(len(sight.forward_m), seen)))
    return sight.distance_m(sight.needed_m(speed_mps, SIGHTINGS))


def difference(forward_m: float) -> float:
    """Of a low body, by its definition."""
    return CONFIG.grains * GRAIN * (CONFIG.grains_at_m / forward_m) ** CONFIG.power


def test_in_clear_air_the_looks_it_takes_are_the_way_that_is_lost() -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    assert told(noise=1.0) == pytest.approx(CONFIG.far_m - way, abs=CONFIG.step_m)


@pytest.mark.parametrize("forward_m", [9.0, 10.0, 11.0])
def test_noise_hides_what_lies_farther_than_its_difference_tells(forward_m: float) -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    assert told(noise=difference(forward_m)) == pytest.approx(forward_m - way, abs=1.01 * CONFIG.step_m)


def test_water_on_half_of_the_road_takes_twice_the_way() -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    assert told(noise=1.0, seen=0.5) == pytest.approx(CONFIG.far_m - 2.0 * way, abs=CONFIG.step_m)


def test_slower_is_farther() -> None:
    far = [told(noise=1.0, speed_mps=speed) for speed in (0.0, 1.0, 3.0, 5.0, 8.0)]
    assert far == sorted(far, reverse=True)
    assert far[0] == pytest.approx(CONFIG.far_m, abs=CONFIG.step_m)


def test_haze_takes_contrast_from_grain_and_body_alike() -> None:
    assert told(noise=100.0, grain=2.0) == told(noise=50.0, grain=1.0) == told(noise=200.0, grain=4.0)


def test_where_there_is_no_grain_or_no_dry_place_nothing_is_seen() -> None:
    assert told(noise=10.0, grain=0.0) == 0.0
    assert told(noise=10.0, seen=0.0) == 0.0


def test_before_the_first_look_the_road_is_believed_to_be_seen() -> None:
    assert told(noise=np.inf, looks=0) == told(noise=1.0)


def test_a_good_view_is_known_beside_whatever_is_seen() -> None:
    way = (SIGHTINGS + CONFIG.spare_looks) * PERIOD_S * 5.0
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    for _ in range(50):
        sight.record(LookQuality(np.inf, GRAIN, np.zeros(len(sight.forward_m))))
    assert sight.distance_m(sight.needed_m(5.0, SIGHTINGS)) == 0.0
    assert sight.good_m(sight.needed_m(5.0, SIGHTINGS)) == pytest.approx(
        CONFIG.far_m - way / CONFIG.good_share, abs=CONFIG.step_m
    )
    assert sight.good_m(sight.needed_m(20.0, SIGHTINGS)) == 0.0, "too fast for any"


def test_one_bad_look_is_no_blindness() -> None:
    sight = SensingRange(CONFIG, NEAR_M, PERIOD_S)
    whole = np.ones(len(sight.forward_m))
    for noise in (1.0, 1.0, np.inf, 1.0):
        sight.record(LookQuality(noise, GRAIN, whole))
    assert sight.distance_m(sight.needed_m(5.0, SIGHTINGS)) > told(noise=1.0) - 0.6


def test_a_configuration_that_makes_no_sense_is_refused() -> None:
    with pytest.raises(ValueError, match="grains: expected > 0"):
        SensingRangeConfig(grains=0.0)
