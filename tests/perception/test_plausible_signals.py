"""Readings that cannot be are replaced; all others pass to the bit."""

import numpy as np
import pytest
from driver_settings import ROBUST

from vpf_sim.driver_interface import Observation
from vpf_sim.perception.plausible import Plausibility
from vpf_sim.types import VehicleModel

RATE_HZ = 60.0


def observation(k: int, x_m: float, speed_mps: float, yaw_rate_radps: float) -> Observation:
    return Observation(np.zeros((0, 0, 3), np.uint8), k / RATE_HZ, x_m, 0.0, 0.0, speed_mps, yaw_rate_radps, (0.0, 0.0))


def test_what_is_plausible_passes_to_the_bit() -> None:
    random = np.random.default_rng(1)
    watch = Plausibility(ROBUST.plausibility, VehicleModel())
    for k in range(300):
        told = observation(k, 0.09 * k, 5.4 + random.normal(0, 0.05), 0.3 + random.normal(0, 0.01))
        assert watch.update(told) is told


def test_a_spike_of_the_yaw_rate_is_left_out() -> None:
    watch = Plausibility(ROBUST.plausibility, VehicleModel())
    found = [watch.update(observation(k, 0.09 * k, 5.4, 0.1 + (k == 20))).yaw_rate_radps for k in range(30)]
    assert found == [0.1] * 30


def test_a_yaw_rate_that_stays_where_it_jumped_to_is_believed() -> None:
    watch = Plausibility(ROBUST.plausibility, VehicleModel())
    found = [watch.update(observation(k, 0.09 * k, 5.4, 0.0 if k < 20 else 1.0)).yaw_rate_radps for k in range(60)]
    assert found[25] == 0.0
    assert found[-1] == 1.0


def test_a_stuck_speedometer_is_replaced_by_the_pace_of_the_pose() -> None:
    watch, x_m, speed = Plausibility(ROBUST.plausibility, VehicleModel()), 0.0, 5.0
    for k in range(180):
        found = watch.update(observation(k, x_m, 5.0, 0.0))
        # what is let pass at 5 m/s, 0.75 m/s, and by what a mean over 0.3 s lags behind at 2 m/s2
        assert found.speed_mps == pytest.approx(speed, abs=0.75 + 0.31)
        speed = max(5.0 - 2.0 * k / RATE_HZ, 1.0)
        x_m += speed / RATE_HZ
    assert found.speed_mps == pytest.approx(1.0, abs=0.05)
