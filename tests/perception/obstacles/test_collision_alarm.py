"""The safety net, from simulated tracks: what is in our way and grows fast, and what is not."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import section
from test_moving_tracker import Traffic, vehicle
from tracked_points import CAMERA, RATE_HZ, SPEED_MPS, Drive, road_points, tracker

from vpf_sim.perception.obstacles.collision_alarm import CollisionAlarm
from vpf_sim.types import Floats, Obstacles

LOOK_FRAMES = 3
NONE = Obstacles(*(np.empty(0) for _ in range(5)), identity=np.empty(0, np.int64))


def watch(drive: Drive, seconds: float, known: int = 0) -> list[Obstacles]:
    """What the net tells at each look; the first `known` points are of an obstacle that is known to move."""
    alarm = CollisionAlarm(CAMERA, section("moving_obstacles.collision_alarm"), LOOK_FRAMES / RATE_HZ)
    landmarks = tracker()
    reported = []
    for frame in range(round(seconds * RATE_HZ)):
        flow = drive.flow(frame)
        if frame % LOOK_FRAMES == 0:
            alarm.look(flow, landmarks.triangulate(flow), drive.road, SPEED_MPS, flow.identity >= known)
            reported.append(alarm.obstacles(flow.pose, SPEED_MPS, NONE))
    return reported


def low(points_m: Floats) -> Floats:
    """The lower half of an obstacle: nothing of it can stand where it seems to."""
    return points_m[points_m[:, 2] < 0.7]


@pytest.mark.parametrize("speed_mps", [0.0, 3.0])
def test_an_object_is_reported_at_its_due_time(speed_mps: float) -> None:
    body = vehicle(22.0, 0.2, 30)
    body = body if speed_mps == 0.0 else low(body)
    closing_mps = SPEED_MPS - speed_mps
    seconds = (22.0 - CAMERA.forward_m) / closing_mps - 1.2
    reported = watch(Traffic(body, np.full(len(body), speed_mps)), seconds)
    alarms = [len(obstacles) for obstacles in reported]
    assert alarms[-1] == 1
    assert sum(alarms) * LOOK_FRAMES / RATE_HZ > 0.5
    left_s = (22.0 - CAMERA.forward_m) / closing_mps - (len(reported) - 1) * LOOK_FRAMES / RATE_HZ
    assert (reported[-1].forward_m[0] - CAMERA.forward_m) / SPEED_MPS == pytest.approx(left_s, rel=0.1)
    assert reported[-1].left_m[0] < 0.2 < reported[-1].right_m[0]
    first = alarms.index(1) * LOOK_FRAMES / RATE_HZ
    assert 1.2 + seconds - first < section("moving_obstacles.collision_alarm").bound_s + 0.1


def test_neither_road_nor_obstacles_beside_the_path_alarm() -> None:
    aside = vehicle(25.0, 3.5, 30)
    road = road_points(400)
    scene = np.concatenate([aside, road[road[:, 1] < 2.0]])
    assert not any(len(obstacles) for obstacles in watch(Traffic(scene, np.zeros(len(scene))), 4.0))


def test_points_of_moving_obstacles_do_not_alarm() -> None:
    body = vehicle(18.0, 0.0, 30)
    assert not any(len(obstacles) for obstacles in watch(Traffic(body, np.zeros(len(body))), 2.5, known=len(body)))


def test_an_alarm_outlasts_a_moment_without_tracks() -> None:
    alarm = CollisionAlarm(CAMERA, section("moving_obstacles.collision_alarm"), LOOK_FRAMES / RATE_HZ)
    drive, landmarks = Traffic(vehicle(14.0, 0.0, 30), np.zeros(32)), tracker()
    places, last = [], round(1.4 * RATE_HZ)
    for frame in range(round(2.4 * RATE_HZ)):
        flow = drive.flow(frame)
        if frame % LOOK_FRAMES == 0:
            free = np.full(len(flow), frame < last)
            alarm.look(flow, landmarks.triangulate(flow), drive.road, SPEED_MPS, free)
            places.append(alarm.obstacles(flow.pose, SPEED_MPS, NONE).forward_m)
    held = places[last // LOOK_FRAMES + 5]
    assert held == pytest.approx([14.0 - SPEED_MPS * (last + 5 * LOOK_FRAMES) / RATE_HZ], abs=0.6)
    assert len(places[-1]) == 0


def test_a_known_obstacle_is_not_reported_again() -> None:
    alarm = CollisionAlarm(CAMERA, section("moving_obstacles.collision_alarm"), LOOK_FRAMES / RATE_HZ)
    drive, landmarks = Traffic(vehicle(14.0, 0.0, 30), np.zeros(32)), tracker()
    for frame in range(round(1.2 * RATE_HZ)):
        flow = drive.flow(frame)
        if frame % LOOK_FRAMES == 0:
            alarm.look(flow, landmarks.triangulate(flow), drive.road, SPEED_MPS, np.ones(len(flow), np.bool_))
    pose = flow.pose
    reported = alarm.obstacles(pose, SPEED_MPS, NONE)
    assert len(reported) == 1
    assert len(alarm.obstacles(pose, SPEED_MPS, reported)) == 0
    beside = replace(reported, left_m=reported.left_m + 4.0, right_m=reported.right_m + 4.0)
    assert len(alarm.obstacles(pose, SPEED_MPS, beside)) == 1
    turned = alarm.obstacles(pose + np.array([0.0, 0.0, 0.2]), SPEED_MPS, NONE)
    assert np.hypot(turned.forward_m, turned.middle_m) == pytest.approx(np.hypot(reported.forward_m, reported.middle_m))
    assert turned.middle_m / turned.forward_m == pytest.approx(
        np.tan(np.arctan2(reported.middle_m, reported.forward_m) - 0.2)
    )
