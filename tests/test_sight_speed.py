"""Speed by what can be seen: a stop within it, from any speed that is allowed."""

from dataclasses import replace

import numpy as np
import pytest

from vpf_sim.planning.sight_speed import SightConfig, safe_speed, within_sight
from vpf_sim.types import Reference, VehicleModel

CONFIG = SightConfig(brake_mps2=3.0, reaction_s=0.3, standoff_m=0.5, least_mps=2.8)
VEHICLE = VehicleModel()


@pytest.mark.parametrize("sight_m", [6.0, 8.0, 10.0, 15.0, 40.0])
def test_the_car_stops_before_what_comes_into_sight(sight_m: float) -> None:
    speed = safe_speed(sight_m, CONFIG, VEHICLE)
    way = speed * CONFIG.reaction_s + speed**2 / (2.0 * CONFIG.brake_mps2)
    assert 0.5 * VEHICLE.length_m + way + CONFIG.standoff_m == pytest.approx(sight_m)


def test_it_never_stands_for_what_cannot_be_seen() -> None:
    for sight_m in (0.0, 1.0, 3.0):
        assert safe_speed(sight_m, CONFIG, VEHICLE) == CONFIG.least_mps


def test_the_reference_is_slowed_only_and_keeps_its_heading() -> None:
    reference = Reference(0.3, 5.55, 0.01)
    assert within_sight(reference, np.inf, CONFIG, VEHICLE) == reference
    assert within_sight(reference, 0.0, CONFIG, VEHICLE) == replace(reference, speed_mps=CONFIG.least_mps)
    slow = replace(reference, speed_mps=0.0)
    assert within_sight(slow, 0.0, CONFIG, VEHICLE) == slow


def test_a_stop_that_makes_no_sense_is_refused() -> None:
    with pytest.raises(ValueError, match="brake_mps2: expected > 0"):
        SightConfig(brake_mps2=0.0, reaction_s=0.3, standoff_m=0.5, least_mps=2.8)
