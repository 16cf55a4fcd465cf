"""The follower of planned motions, in closed loop with a kinematic bicycle."""

from math import asin, atan2, hypot, pi

import pytest
from bicycle import Bicycle

from vpf_sim.controllers import trajectory
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import TrackingTarget, VehicleModel


def course_rad(car: Bicycle) -> float:
    return car.yaw_rad + asin(car.yaw_rate_radps * car.model.l_r_m / max(car.speed_mps, 0.5))


@pytest.mark.parametrize("speed_mps", [3.0, 8.0, 25.0])
def test_a_lateral_error_decays_without_overshoot(speed_mps: float) -> None:
    car = Bicycle(y_m=0.5, speed_mps=speed_mps)
    errors = []
    for _ in range(600):
        target = TrackingTarget(car.y_m, wrap_angle(course_rad(car)), 0.0, speed_mps, 0.0, 0.0)
        car.step(trajectory.command(target, car.speed_mps, car.model))
        errors.append(car.y_m)
    assert abs(errors[-1]) < 0.01
    assert min(errors) > -0.1


def test_it_stays_on_a_circle() -> None:
    car, radius_m = Bicycle(speed_mps=5.0), 15.0
    for _ in range(900):
        off_m = radius_m - hypot(car.x_m, car.y_m - radius_m)
        direction = atan2(car.y_m - radius_m, car.x_m) + pi / 2.0
        target = TrackingTarget(off_m, wrap_angle(course_rad(car) - direction), 1.0 / radius_m, 5.0, 0.0, 0.0)
        car.step(trajectory.command(target, car.speed_mps, car.model))
    assert abs(off_m) < 0.03


def test_a_car_that_shall_stand_is_held() -> None:
    command = trajectory.command(TrackingTarget(0.0, 0.0, 0.0, 0.0, 0.0, 2.0), 0.0, VehicleModel())
    assert command.throttle < 0.0


def test_the_planned_acceleration_is_commanded() -> None:
    command = trajectory.command(TrackingTarget(0.0, 0.0, 0.0, 5.0, -3.0, 0.0), 5.0, VehicleModel())
    assert command.throttle == pytest.approx(-0.5)  # of 6 m/s^2
