"""The waypoint PID: CARLA's structure and limits, and a closed loop on a straight and a bend."""

import numpy as np
import pytest
from bicycle import Bicycle

from vpf_sim.controllers.pid import Pid, WaypointPid, load_gains
from vpf_sim.types import Floats

GAINS = load_gains()


def route(radius_m: float, straight_m: float = 40.0, length_m: float = 160.0) -> Floats:
    """Waypoints 1 m apart: a straight along X, then an arc; radius > 0 bends right."""
    s = np.arange(0.0, length_m + 30.0)
    angle = np.maximum(s - straight_m, 0.0) / radius_m
    x = np.minimum(s, straight_m) + radius_m * np.sin(angle)
    return np.stack([x, radius_m * (1.0 - np.cos(angle))], axis=1)


@pytest.mark.parametrize("rate_hz", [60.0, 20.0])
@pytest.mark.parametrize("radius_m", [100.0, -100.0, 1e9])
def test_pid_follows_a_straight_and_a_bend(radius_m: float, rate_hz: float) -> None:
    path = route(radius_m)
    car = Bicycle(y_m=0.3, rate_hz=rate_hz)
    control = WaypointPid(GAINS, path, 5.55, rate_hz)
    offsets = []
    for _ in range(int(28.0 * rate_hz)):
        car.step(control.command(car.observe()))
        offsets.append(np.min(np.hypot(*(path - [car.x_m, car.y_m]).T)))
    # Between waypoints 1 m apart the nearest is up to 0.5 m away, along the path.
    across = np.sqrt(np.maximum(np.square(offsets) - 0.25, 0.0))[int(4 * rate_hz) :]
    assert across.max() < 0.2
    assert car.speed_mps == pytest.approx(5.55, abs=0.05)


def test_the_integral_is_a_window_of_the_last_errors() -> None:
    pid = Pid(kp=0.0, ki=1.0, kd=0.0, buffer_steps=10, dt_s=0.05)
    assert pid.step(0.1) == 0.0  # as in CARLA, the first step has no integral
    for _ in range(30):
        last = pid.step(0.1)
    assert last == pytest.approx(10 * 0.1 * 0.05)
    for _ in range(10):
        last = pid.step(0.0)
    assert last == 0.0


def test_the_derivative_and_the_clip() -> None:
    pid = Pid(kp=1.0, ki=0.0, kd=0.2, buffer_steps=10, dt_s=0.05)
    pid.step(0.1)
    assert pid.step(0.15) == pytest.approx(0.15 + 0.2 * 0.05 / 0.05)
    assert pid.step(50.0) == 1.0


def test_steering_is_limited_in_rate_and_range_and_held() -> None:
    control = WaypointPid(GAINS, route(1e9), 5.55, 60.0)
    car = Bicycle(yaw_rad=-1.5)
    steering = [control.command(car.observe()).steering for _ in range(60)]
    assert steering[:7] == pytest.approx([0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3])
    assert max(steering) == pytest.approx(0.8)


def test_throttle_and_brake_are_limited() -> None:
    slow = WaypointPid(GAINS, route(1e9), 5.55, 60.0).command(Bicycle(speed_mps=0.0).observe())
    fast = WaypointPid(GAINS, route(1e9), 5.55, 60.0).command(Bicycle(speed_mps=9.0).observe())
    assert (slow.throttle, fast.throttle) == (0.75, -0.3)


def test_reset_clears_the_state() -> None:
    control = WaypointPid(GAINS, route(100.0), 5.55, 60.0)
    car = Bicycle(y_m=0.5)
    first = [control.command(car.observe()) for _ in range(10)]
    control.reset()
    assert [control.command(car.observe()) for _ in range(10)] == first
