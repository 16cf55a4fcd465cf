"""The way by speed and yaw rate, against a way in closed form and sensors with known errors."""

from dataclasses import replace
from itertools import pairwise
from math import cos, hypot, pi, radians, sin

import numpy as np
import pytest
from driver_settings import ROBUST

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers import VisionDriver
from vpf_sim.geometry import wrap_angle
from vpf_sim.perception.egomotion.odometry import Odometry
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image, VehicleModel

RATE_HZ, FRAMES = 60.0, 900
L_R_M = VehicleModel().l_r_m
BLANK: Image = np.zeros((0, 0, 3), np.uint8)
WINDOW = 42  # frames that points are followed


def true_way() -> Floats:
    """(FRAMES, 5) x, y, yaw, speed, yaw rate of a car that swerves, brakes and goes on: fine steps, one kept in ten."""
    rows, (x, y, yaw) = [], (3.0, -2.0, 0.4)
    step_s = 0.1 / RATE_HZ
    for k in range(10 * FRAMES):
        time_s = k * step_s
        speed = 4.0 + 1.5 * cos(0.7 * time_s)
        rate = 0.25 * sin(1.1 * time_s)
        if k % 10 == 0:
            rows.append((x, y, yaw, speed, rate))
        course = yaw + np.arcsin(L_R_M * rate / speed)
        x, y, yaw = x + speed * cos(course) * step_s, y + speed * sin(course) * step_s, yaw + rate * step_s
    return np.array(rows)


TRUE = true_way()


def observations(errors: dict[str, float], seed: int = 3) -> list[Observation]:
    """What sensors with these errors read on that way; `walk` in a second, the others of each reading."""
    random = stream(seed, "sensors")
    walk = np.cumsum(random.standard_normal((FRAMES, 3)), axis=0) / np.sqrt(RATE_HZ)
    walk = walk * [errors.get("walk_m", 0.0), errors.get("walk_m", 0.0), errors.get("walk_rad", 0.0)]
    keys = ("noise_m", "noise_m", "noise_rad", "speed_mps", "rate_radps")
    read = TRUE + random.standard_normal((FRAMES, 5)) * [errors.get(key, 0.0) for key in keys]
    read[:, :3] += walk
    read[:, 3] = errors.get("scale", 1.0) * read[:, 3]
    read[:, 4] += errors.get("bias_radps", 0.0)
    return [Observation(BLANK, k / RATE_HZ, *row, goal_m=(0.0, 0.0)) for k, row in enumerate(read.tolist())]


def followed(seen: list[Observation]) -> tuple[Odometry, list[Observation]]:
    assert ROBUST.odometry is not None
    odometry = Odometry(ROBUST.odometry, VehicleModel())
    return odometry, [odometry.update(one) for one in seen]


def errors_of_base_lines(seen: list[Observation]) -> tuple[float, float]:
    """rms m across and rad by which the way over some frames is wrong, once the sensors are known."""

    def base_line(first: Floats, last: Floats) -> Floats:
        way = last[:2] - first[:2]
        cosine, sine = cos(first[2]), sin(first[2])
        return np.array([cosine * way[1] - sine * way[0], wrap_angle(float(last[2] - first[2]))])

    poses = np.array([(one.x_m, one.y_m, one.yaw_rad) for one in seen])
    wrong = [
        base_line(poses[k - WINDOW], poses[k]) - base_line(TRUE[k - WINDOW, :3], TRUE[k, :3])
        for k in range(300, FRAMES, 11)
    ]
    across, turn = np.sqrt(np.mean(np.square(wrong), axis=0)).tolist()
    return across, turn


@pytest.mark.parametrize(
    "errors", [{}, {"scale": 1.05}, {"speed_mps": 0.05}, {"rate_radps": 0.01, "bias_radps": 0.01}], ids=str
)
def test_a_smooth_pose_is_left_as_it_is(errors: dict[str, float]) -> None:
    seen = observations(errors)
    odometry, believed = followed(seen)
    assert not odometry.is_needed
    assert all(one is other for one, other in zip(seen, believed, strict=True))


@pytest.mark.parametrize(
    "errors",
    [
        {"walk_m": 0.05, "walk_rad": radians(0.1)},
        {"noise_m": 0.01, "noise_rad": radians(0.05)},
        {"walk_m": 0.05, "walk_rad": radians(0.1), "scale": 1.03, "bias_radps": 0.01},
    ],
    ids=["walk", "noise", "walk, scale and bias"],
)
def test_base_lines_are_better_than_those_of_a_rough_pose(errors: dict[str, float]) -> None:
    seen = observations(errors)
    odometry, believed = followed(seen)
    assert odometry.is_needed
    (across, turn), (raw_across, raw_turn) = errors_of_base_lines(believed), errors_of_base_lines(seen)
    assert across < 0.15 * raw_across
    assert turn < 0.6 * raw_turn


def test_scale_and_bias_are_told_by_the_pose() -> None:
    errors = {"walk_m": 0.05, "walk_rad": radians(0.1), "scale": 0.96, "speed_mps": 0.05, "bias_radps": -0.012}
    odometry, believed = followed(observations({**errors, "rate_radps": 0.01}))
    assert odometry.scale == pytest.approx(1.0 / 0.96, abs=0.012)
    assert odometry.bias_radps == pytest.approx(-0.012, abs=0.0015)
    assert np.mean([one.speed_mps for one in believed[-60:]]) == pytest.approx(np.mean(TRUE[-60:, 3]), rel=0.015)
    assert np.mean([one.yaw_rate_radps for one in believed[-60:]]) == pytest.approx(np.mean(TRUE[-60:, 4]), abs=0.005)


def test_the_way_goes_on_where_the_pose_was_left() -> None:
    """No jump at the moment in which speed and yaw rate take over, nor where the yaw passes from pi to -pi."""
    seen = observations({"noise_rad": radians(0.05)})
    turned = [replace(one, x_m=-one.x_m, y_m=-one.y_m, yaw_rad=wrap_angle(one.yaw_rad + pi)) for one in seen]
    odometry, believed = followed(turned)
    assert odometry.is_needed
    turns = [wrap_angle(later.yaw_rad - one.yaw_rad) for one, later in pairwise(believed)]
    assert np.abs(turns).max() < 0.01
    assert all(-pi <= one.yaw_rad < pi for one in believed)


@pytest.mark.parametrize(("noise_mps", "most_m"), [(0.0, 0.007), (0.05, 0.03)], ids=["exact", "noisy"])
def test_a_car_that_stands_stays_where_it_is_and_does_not_turn(noise_mps: float, most_m: float) -> None:
    """Its speedometer's noise is cut off at 0, so that it adds up; its yaw rate has a bias."""
    noise = np.maximum(stream(8, "speed").normal(0.0, 1.0, FRAMES) * noise_mps, 0.0)
    still = [
        replace(one, x_m=0.003 * (k % 3), y_m=0.0, yaw_rad=1.0, speed_mps=float(noise[k]), yaw_rate_radps=0.01)
        for k, one in enumerate(observations({}))
    ]
    odometry, believed = followed(still)
    assert odometry.is_needed
    assert hypot(believed[-1].x_m, believed[-1].y_m) < most_m
    assert believed[-1].yaw_rad == pytest.approx(1.0, abs=0.001)


def test_the_driver_goes_by_it() -> None:
    driver = VisionDriver("robust")
    camera = Camera()
    driver.reset(DriverSetup(camera, VehicleModel(), RATE_HZ, 5.55, (200.0, 0.0), 1))
    blank: Image = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)
    seen = [replace(one, image=blank) for one in observations({"noise_m": 0.05})[:30]]
    _, believed = followed(seen)
    for one, other in zip(seen, believed, strict=True):
        driver.act(one)
        plan = driver.trace()
        assert plan is not None
        assert plan.perception.pose == pytest.approx([other.x_m, other.y_m, other.yaw_rad])
    assert believed[-1] is not seen[-1]
