"""The ego car against closed forms: circles, stopping distances, steering rate."""

from math import atan, cos, pi, radians, sin, tan

import numpy as np
import pytest

from vpf_sim.envs.camera import weather
from vpf_sim.envs.ego import GRAVITY_MPS2, Ego
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.road import build_road
from vpf_sim.scenarios import load

WHEELBASE_M = 2.7
L_R_M = WHEELBASE_M / 2.0


def ego_car(speed: float = 5.55, heading: float = 0.0, friction: float | None = None) -> Ego:
    road = build_road(load("straight"), np.random.default_rng(0))
    return Ego(road, np.array([20.0, 1.75]), heading, speed, friction)


def turned(steering: float, speed: float, friction: float | None = None) -> Ego:
    """A car with its wheels already at the steering angle."""
    ego = ego_car(speed, friction=friction)
    ego.steering_rad = steering
    ego.act({"acceleration": 0.0, "steering": steering})
    return ego


@pytest.mark.parametrize("steering_deg", [-35.0, -3.0, 0.01, 12.0, 40.0])
@pytest.mark.parametrize("rate_hz", [60.0, 20.0, 2.0])
def test_a_constant_steering_angle_keeps_the_car_on_its_circle(steering_deg: float, rate_hz: float) -> None:
    ego = turned(radians(steering_deg), 8.0)
    beta = atan(0.5 * tan(radians(steering_deg)))
    radius = L_R_M / sin(beta)  # of the centre of mass, + to the right
    centre = ego.position + radius * np.array([-sin(beta), cos(beta)])  # right of the course
    for _ in range(round(5.0 * rate_hz)):
        ego.step(1.0 / rate_hz)
        assert np.hypot(*(ego.position - centre)) == pytest.approx(abs(radius), rel=1e-12)
    assert ego.heading == pytest.approx(8.0 * 5.0 / radius, rel=1e-12)
    assert ego.yaw_rate_radps == pytest.approx(8.0 / radius, rel=1e-12)


def test_positive_steering_turns_right() -> None:
    ego = turned(radians(10.0), 5.0)
    for _ in range(60):
        ego.step(1.0 / 60.0)
    assert ego.heading > 0.0
    assert ego.position[1] > 1.75


def test_braking_stops_at_the_stopping_distance_without_reversing() -> None:
    ego = ego_car(speed=10.03)  # so that it comes to stand within a step
    ego.act({"acceleration": -6.0, "steering": 0.0})
    for _ in range(200):
        ego.step(1.0 / 60.0)
        assert ego.speed >= 0.0
    assert ego.speed == 0.0
    assert ego.position[0] - 20.0 == pytest.approx(10.03**2 / (2.0 * 6.0), rel=1e-12)


def test_throttle_from_standing_is_half_a_t_squared() -> None:
    ego = ego_car(speed=0.0, heading=pi / 6.0)
    ego.act({"acceleration": 3.0, "steering": 0.0})
    for _ in range(120):
        ego.step(1.0 / 60.0)
    assert ego.speed == pytest.approx(6.0)
    assert ego.position - [20.0, 1.75] == pytest.approx([6.0 * cos(pi / 6.0), 6.0 * sin(pi / 6.0)])


def test_steering_rate_and_angle_are_limited() -> None:
    ego = ego_car()
    ego.act({"acceleration": 0.0, "steering": 10.0})
    angles = []
    for _ in range(60):
        ego.step(1.0 / 60.0)
        angles.append(ego.steering_rad)
    assert np.diff([0.0, *angles])[:41] == pytest.approx(1.0 / 60.0)
    assert angles[-1] == radians(40.0)
    ego.act({"acceleration": 0.0, "steering": -10.0})
    ego.step(1.0 / 60.0)
    assert ego.steering_rad == pytest.approx(radians(40.0) - 1.0 / 60.0)


def test_command_is_copied_and_not_modified() -> None:
    ego, command = ego_car(), {"acceleration": 1.0, "steering": 2.0}
    ego.act(command)
    ego.step(1.0 / 60.0)
    assert command == {"acceleration": 1.0, "steering": 2.0}
    command["acceleration"] = -6.0
    ego.step(1.0 / 60.0)
    assert ego.speed == pytest.approx(5.55 + 2.0 / 60.0)


def test_command_is_held_until_the_next() -> None:
    ego = ego_car(speed=0.0)
    ego.act({"acceleration": 1.5, "steering": 0.0})
    ego.act()
    ego.step(1.0)
    assert ego.speed == 1.5


def test_the_velocity_has_the_slip_angle() -> None:
    ego = turned(radians(30.0), 7.0)
    before = ego.position
    ego.step(1e-4)
    assert ego.velocity == pytest.approx((ego.position - before) / 1e-4, abs=2e-3)


def test_the_lane_follows_the_position() -> None:
    ego = ego_car(speed=10.0, heading=pi / 2.0)
    assert ego.lane_index[2] == 2
    ego.act({"acceleration": 0.0, "steering": 0.0})
    ego.step(0.35)
    assert ego.lane_index[2] == 3
    assert ego.place == pytest.approx((20.0, 5.25))


def test_contact_impulse_does_not_move_the_car() -> None:
    ego = ego_car()
    ego.act({"acceleration": 0.0, "steering": 0.0})
    ego.impact = np.array([3.0, 3.0])
    ego.step(1.0 / 60.0)
    assert ego.position == pytest.approx([20.0 + 5.55 / 60.0, 1.75])
    assert not ego.crashed


def test_friction_limits_braking() -> None:
    ego = ego_car(speed=10.03, friction=0.3)
    ego.act({"acceleration": -6.0, "steering": 0.0})
    for _ in range(400):
        ego.step(1.0 / 60.0)
    assert ego.speed == 0.0
    assert ego.position[0] - 20.0 == pytest.approx(10.03**2 / (2.0 * 0.3 * GRAVITY_MPS2), rel=1e-12)


@pytest.mark.parametrize("steering_deg", [-20.0, 20.0])
def test_friction_limits_cornering(steering_deg: float) -> None:
    ego = turned(radians(steering_deg), 8.0, friction=0.3)
    held = 0.3 * GRAVITY_MPS2
    for _ in range(120):
        ego.step(1.0 / 60.0)
    assert ego.heading == pytest.approx(np.sign(steering_deg) * 2.0 * held / 8.0, rel=1e-12)
    assert ego.yaw_rate_radps == pytest.approx(np.sign(steering_deg) * held / 8.0, rel=1e-12)
    assert ego.speed == 8.0


def test_braking_in_a_bend_shares_the_friction_between_both() -> None:
    ego = turned(radians(20.0), 8.0, friction=0.3)
    ego.act({"acceleration": -4.0, "steering": radians(20.0)})
    across = 8.0**2 * sin(atan(0.5 * tan(radians(20.0)))) / L_R_M
    ego.step(1e-4)
    along = (ego.speed - 8.0) / 1e-4
    assert np.hypot(along, ego.heading / 1e-4 * 8.0) == pytest.approx(0.3 * GRAVITY_MPS2, rel=1e-4)
    assert along / (ego.heading / 1e-4 * 8.0) == pytest.approx(-4.0 / across, rel=1e-4)


def test_motion_within_friction_equals_the_dry_road() -> None:
    cars = [turned(radians(3.0), 8.0, friction) for friction in (None, 0.3)]
    for ego in cars:
        ego.act({"acceleration": 1.0, "steering": radians(-4.0)})
        for _ in range(60):
            ego.step(1.0 / 60.0)
    assert np.array_equal(cars[0].position, cars[1].position)
    assert cars[0].heading == cars[1].heading


def test_friction_comes_from_the_weather_only() -> None:
    for name, changes, expected in (("rain", {}, None), ("clear", {"road_friction": 0.4}, 0.4)):
        env = FourLane("straight", weather.load(name).model_copy(update=changes))
        env.reset(seed=1)
        assert env.ego.friction == expected
