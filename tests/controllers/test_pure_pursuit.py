"""Pure pursuit against closed forms: a circle of the rear axle, and the decay towards a straight."""

from math import cos, exp, hypot, sin

import numpy as np
import pytest
from bicycle import Bicycle
from test_polyline import circle

from vpf_sim.controllers.pure_pursuit import Gains, PurePursuit, load_gains
from vpf_sim.driver_interface import Command
from vpf_sim.types import Floats, VehicleModel

MODEL = VehicleModel()


def drive(route_m: Floats, car: Bicycle, time_s: float) -> Floats:
    """(n, 2) m, positions of the rear axle."""
    control = PurePursuit(load_gains(), route_m, MODEL)
    places = []
    for _ in range(int(time_s * car.rate_hz)):
        car.step(Command(0.0, control.steer(car.observe())))
        places.append((car.x_m - MODEL.l_r_m * cos(car.yaw_rad), car.y_m - MODEL.l_r_m * sin(car.yaw_rad)))
    return np.array(places)


@pytest.mark.parametrize("radius_m", [30.0, -30.0, 80.0])
def test_on_a_circle_the_rear_axle_has_no_steady_error(radius_m: float) -> None:
    """The centre of mass, l_r ahead of it, runs outside by sqrt(R^2 + l_r^2) - R."""
    car = Bicycle(y_m=0.3, rate_hz=200.0)
    rear = drive(circle(radius_m, 0.1), car, 12.0)[-200:]
    assert np.hypot(rear[:, 0], rear[:, 1] - radius_m) == pytest.approx(abs(radius_m), abs=4e-3)
    centre_m = hypot(car.x_m, car.y_m - radius_m)
    assert centre_m == pytest.approx(hypot(radius_m, MODEL.l_r_m), abs=4e-3)


@pytest.mark.parametrize("side_m", [0.1, -0.1])
def test_offset_from_a_straight_decays_as_a_damped_wave(side_m: float) -> None:
    """y = y0 exp(-s / l) (cos(s / l) + sin(s / l)), with 4.3 % of overshoot, exp(-pi)."""
    reach_m = load_gains().look_ahead_m
    route = np.column_stack([np.arange(-5.0, 60.0), np.zeros(65)])
    x, y = drive(route, Bicycle(x_m=MODEL.l_r_m, y_m=side_m, rate_hz=200.0), 6.0).T
    waves = np.exp(-x / reach_m) * (np.cos(x / reach_m) + np.sin(x / reach_m))
    assert y / side_m == pytest.approx(waves, abs=0.03)
    assert float(np.min(y / side_m)) == pytest.approx(-exp(-np.pi), abs=0.01)


def test_steering_saturates_towards_a_distant_line() -> None:
    route = np.column_stack([np.arange(80.0), np.zeros(80)])
    control = PurePursuit(load_gains(), route, MODEL)
    assert control.steer(Bicycle(x_m=10.0, y_m=5.5).observe()) == -1.0
    assert control.steer(Bicycle(x_m=10.0, y_m=-5.5).observe()) == 1.0


def test_a_look_ahead_must_be_positive() -> None:
    with pytest.raises(ValueError, match=r"look_ahead_m: expected > 0, got 0\.0"):
        Gains(0.0)
