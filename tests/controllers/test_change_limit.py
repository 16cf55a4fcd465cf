"""The limit on acceleration changes, and the resulting jerk by nuPlan's measure."""

import numpy as np
import pytest
from bicycle import Bicycle

from vpf_sim.braking import comfortable_speed
from vpf_sim.controllers.gtsmc import ChangeLimit, Gtsmc, load_gains
from vpf_sim.evaluation.metrics.comfort import BOUNDS, nuplan_signals
from vpf_sim.types import Floats, Reference, VehicleModel

RATE_HZ = 60.0


def limited(demands: Floats, limit_mps2: float, window_s: float) -> Floats:
    change_limit = ChangeLimit(limit_mps2, window_s, 1.0 / RATE_HZ)
    return np.array([change_limit.limit(float(demand)) for demand in demands])


def test_change_within_the_limit_passes_at_once() -> None:
    demands = np.repeat([0.0, -3.0, 0.0, 2.0], 120)
    assert np.array_equal(limited(demands, 3.0, 0.9), demands)


def test_change_stays_within_the_limit_and_the_demand_is_reached() -> None:
    demands = np.repeat([1.5, -3.6, 1.5], 120)
    given = limited(demands, 3.75, 0.9)
    steps = round(0.9 * RATE_HZ)
    spans = [np.ptp(given[at : at + steps + 1]) for at in range(len(given) - steps)]
    assert max(spans) == pytest.approx(3.75)
    assert given[120] == pytest.approx(1.5 - 3.75)
    assert given[120 + steps] == -3.6


@pytest.mark.parametrize("braking_s", [0.3, 0.6, 1.2, 3.0])
def test_alternating_throttle_and_brake_stays_within_nuplan_bounds(braking_s: float) -> None:
    """At the strongest comfort braking of the gains."""
    car, control, rows = Bicycle(speed_mps=3.0), Gtsmc(load_gains("robust"), VehicleModel(), RATE_HZ), []
    while car.time_s < 4.0 + braking_s:
        wanted = max(comfortable_speed(car.speed_mps), 0.0) if 1.0 <= car.time_s < 1.0 + braking_s else 9.0
        car.step(control.command(car.observe(), Reference(0.0, wanted, 0.0)))
        rows.append((car.time_s, car.speed_mps, car.yaw_rad, car.yaw_rate_radps))
    signals = nuplan_signals(*np.array(rows).T)
    assert signals is not None
    for signal, bound in ((signals[key], BOUNDS[key]) for key in BOUNDS):
        assert bound.low < signal.min()
        assert signal.max() < bound.high


@pytest.mark.parametrize("speed_mps", [1.6, 2.1, 2.6, 3.6, 5.1])
def test_emergency_stop_from_acceleration_beats_a_0(speed_mps: float) -> None:
    """An obstacle detected late: the comfort limit does not delay emergency braking."""
    car, control = Bicycle(speed_mps=speed_mps - 1.5), Gtsmc(load_gains("robust"), VehicleModel(), RATE_HZ)
    while car.speed_mps < speed_mps:
        car.step(control.command(car.observe(), Reference(0.0, car.speed_mps + 0.8, 0.0)))
    start_m, speed = car.x_m, car.speed_mps
    while car.speed_mps > 0.05 and car.time_s < 10.0:
        car.step(control.command(car.observe(), Reference(0.0, 0.0, 0.0)))
    by_a_0 = (speed**2 - 1.0) / (2.0 * 3.6) + 1.0 / 3.6  # in the boundary layer of 1 m/s the speed decays
    assert car.x_m - start_m < by_a_0
