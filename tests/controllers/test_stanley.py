"""The Stanley controller against closed forms: a circle of the front axle, and the decay towards a straight."""

from math import cos, hypot, sin, sqrt

import numpy as np
import pytest
from bicycle import Bicycle
from test_polyline import circle

from vpf_sim.controllers.stanley import Gains, Stanley, load_gains
from vpf_sim.driver_interface import Command
from vpf_sim.types import Floats, VehicleModel

MODEL = VehicleModel()
GAINS = load_gains()


def drive(route_m: Floats, car: Bicycle, time_s: float) -> Floats:
    """(n, 2) m, positions of the front axle."""
    control = Stanley(GAINS, route_m, MODEL)
    places = []
    for _ in range(int(time_s * car.rate_hz)):
        car.step(Command(0.0, control.steer(car.observe())))
        places.append((car.x_m + MODEL.l_f_m * cos(car.yaw_rad), car.y_m + MODEL.l_f_m * sin(car.yaw_rad)))
    return np.array(places)


@pytest.mark.parametrize("radius_m", [30.0, -30.0, 80.0])
def test_on_a_circle_the_front_axle_has_no_steady_error(radius_m: float) -> None:
    """The centre of mass runs inside, at sqrt(R^2 - L^2 + l_r^2)."""
    car = Bicycle(y_m=0.3, rate_hz=200.0)
    front = drive(circle(radius_m, 0.1), car, 12.0)[-200:]
    assert np.hypot(front[:, 0], front[:, 1] - radius_m) == pytest.approx(abs(radius_m), abs=5e-3)
    centre_m = sqrt(radius_m**2 - MODEL.wheelbase_m**2 + MODEL.l_r_m**2)
    assert hypot(car.x_m, car.y_m - radius_m) == pytest.approx(centre_m, abs=5e-3)


@pytest.mark.parametrize("side_m", [0.1, -0.1])
def test_offset_from_a_straight_decays_exponentially(side_m: float) -> None:
    """e = e0 exp(-k v / (k_s + v) t), once the wheels have turned."""
    car = Bicycle(x_m=-MODEL.l_f_m, y_m=side_m, rate_hz=200.0)
    error = drive(np.column_stack([np.arange(-5.0, 60.0), np.zeros(65)]), car, 4.0)[:, 1] / side_m
    time_s = np.arange(1, len(error) + 1) / 200.0
    rate_per_s = GAINS.k_per_s * car.speed_mps / (GAINS.softening_mps + car.speed_mps)
    assert error == pytest.approx(np.exp(-rate_per_s * time_s), abs=0.05)
    late = slice(100, 300)
    slope = np.polyfit(time_s[late], np.log(error[late]), 1)[0]
    assert slope == pytest.approx(-rate_per_s, rel=0.03)


def test_softening_limits_steering_at_standstill() -> None:
    """Without the softening any error would ask for 90 deg; with it, for atan(k e / k_s)."""
    control = Stanley(GAINS, np.column_stack([np.arange(80.0), np.zeros(80)]), MODEL)
    steering_rad = control.steer(Bicycle(y_m=0.01, speed_mps=0.0).observe()) * MODEL.steering_limit_rad
    assert steering_rad == pytest.approx(-GAINS.k_per_s * 0.01 / GAINS.softening_mps, rel=1e-3)


def test_steering_saturates_towards_a_distant_line() -> None:
    control = Stanley(GAINS, np.column_stack([np.arange(80.0), np.zeros(80)]), MODEL)
    assert control.steer(Bicycle(y_m=9.0).observe()) == -1.0
    assert control.steer(Bicycle(y_m=-9.0).observe()) == 1.0


def test_gains_must_be_positive() -> None:
    with pytest.raises(ValueError, match=r"softening_mps: expected > 0, got 0\.0"):
        Gains(2.5, 0.0)
