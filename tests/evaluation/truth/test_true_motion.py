"""True motion over several frames, in closed form and against the renderer's own flow."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from highway_scenes import add_ego, add_object, bent_road, on_bend

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.evaluation.truth.true_motion import Shot, TrueMotion, at, moved_points, ttc_errors
from vpf_sim.types import Camera, Floats

CAMERA = Camera()


class Body:
    """An object that is moved from frame to frame."""

    def __init__(self) -> None:
        self.position, self.heading = (0.0, 0.0), 0.0


def motion_of(poses: list[Floats], *objects: dict[Body, tuple[float, float, float]]) -> TrueMotion:
    """True motion after frames at these poses; `objects` has those of each frame with their poses, in order."""
    motion = TrueMotion(CAMERA, len(poses) - 1)
    for k, pose in enumerate(poses):
        here = objects[k] if objects else {}
        for body, place in here.items():
            body.position, body.heading = place[:2], place[2]
        renderer: Any = SimpleNamespace(objects=list(here))
        motion.add(Shot(k, np.empty((0, 0, 3), np.uint8), pose, renderer))
    return motion


def wall(depth_m: float, instance: int) -> dict[str, Any]:
    """A wall across the whole frame."""
    return {"depth": np.full((480, 640), depth_m, np.float32), "instance": np.full((480, 640), instance, np.int32)}


def test_driving_at_a_wall_expands_it_from_the_principal_point() -> None:
    poses = [np.array([0.5 * k, 0.0, 0.0]) for k in range(4)]
    points = np.array([[400.0, 300.0], [100.0, 50.0]])
    expected = (points - (319.5, 239.5)) * 1.5 / (10.0 + 1.5)  # three steps on, 10 m before it
    frames = np.array([3, 3])
    motion = motion_of(poses)
    assert motion.errors_px(points, expected, frames, wall(10.0, -1)).max() < 1e-9
    missed = motion.errors_px(points, expected + np.array([0.0, 30.0]), frames, wall(10.0, -1))
    assert missed == pytest.approx([30.0, 30.0], abs=0.2)


def test_each_track_has_its_own_number_of_frames() -> None:
    poses = [np.array([0.5 * k, 0.0, 0.0]) for k in range(4)]
    points = np.array([[400.0, 300.0]] * 3)
    away = points[0] - (319.5, 239.5)
    expected = np.array([away * d / (10.0 + d) for d in (0.5, 1.0, 1.5)])
    assert motion_of(poses).errors_px(points, expected, np.array([1, 2, 3]), wall(10.0, -1)).max() < 1e-9


def test_the_sky_moves_with_the_turn_alone() -> None:
    poses = [np.array([0.0, 0.0, 0.0]), np.array([5.0, 0.0, 0.02])]
    points = np.array([[319.0, 100.0]])
    x = -0.5 / 320.0
    expected = np.array([[320.0 * (x - np.tan(np.arctan(x) + 0.02)), 0.0]])
    error = motion_of(poses).errors_px(points, expected, np.array([1]), wall(np.inf, 0))
    assert error[0] < 1.5  # rows away from the horizon move a little too
    assert error[0] < 0.3 * abs(expected[0, 0])


def test_a_leader_that_keeps_its_distance_does_not_move() -> None:
    poses = [np.array([k, 0.0, 0.0], float) for k in range(2)]
    leader = Body()
    motion = motion_of(poses, *({leader: (12.0 + k, 0.0, 0.0)} for k in range(2)))
    still = np.zeros((1, 2))
    assert motion.errors_px(np.array([[350.0, 250.0]]), still, np.array([1]), wall(10.0, 1))[0] < 1e-9
    assert motion.errors_px(np.array([[600.0, 400.0]]), still, np.array([1]), wall(10.0, -1))[0] > 5.0


def test_objects_that_come_and_go_do_not_change_those_that_stay() -> None:
    poses = [np.array([k, 0.0, 0.0], float) for k in range(2)]
    leader, gone, new = Body(), Body(), Body()
    before, after = (
        {gone: (50.0, 9.0, 1.0), leader: (12.0, 0.0, 0.0)},
        {leader: (13.0, 0.0, 0.0), new: (40.0, 0.0, 0.0)},
    )
    motion = motion_of(poses, before, after)
    point, one = np.array([[350.0, 250.0]]), np.array([1])
    assert motion.errors_px(point, np.zeros((1, 2)), one, wall(10.0, 1))[0] < 1e-9
    expanded = (point - (319.5, 239.5)) * 1.0 / (10.0 + 1.0)  # who was not there yet counts as standing
    assert motion.errors_px(point, expanded, one, wall(10.0, 2))[0] < 1e-9


def test_a_moved_point_keeps_its_position_on_the_object() -> None:
    now, then = np.array([5.0, 2.0, 0.4]), np.array([1.0, -3.0, -0.2])
    back = moved_points(moved_points(np.array([[6.0, 3.0, 1.2]]), now, then), then, now)
    assert back == pytest.approx(np.array([[6.0, 3.0, 1.2]]))
    assert moved_points(np.array([[5.0, 2.0, 0.0]]), now, then) == pytest.approx(np.array([[1.0, -3.0, 0.0]]))


def test_one_frame_of_a_rendered_bend_agrees_with_the_truth() -> None:
    road = bent_road()
    ego = add_ego(road, *on_bend(2.0, 1.75))
    add_object(road, "van", *on_bend(16.0, 3.5))
    renderer = Renderer(road, Rig(noise_sd=0.0), weather.load("clear"), 4)
    motion = TrueMotion(CAMERA, 1)
    for k in range(2):
        place, ego.heading = on_bend(2.0 + 0.1 * k, 1.75)
        ego.position = np.array(place)
        image = renderer.render(ego, k / 60.0)
        motion.add(Shot(k, image, np.array([*ego.position, ego.heading]), renderer))
    truth = renderer.truth(("depth", "instance", "flow"))
    points = np.random.default_rng(0).uniform((0.0, 0.0), (639.0, 479.0), (400, 2)).round()
    flow = at(truth["flow"], points, CAMERA).astype(float)
    assert motion.errors_px(points, flow, np.ones(400, np.int64), truth).max() < 1e-2


def test_values_are_read_at_the_nearest_pixel() -> None:
    values = np.arange(480 * 640).reshape(480, 640)
    points = np.array([[0.4, 0.4], [638.6, 479.4], [-3.0, 1.0]])
    assert at(values, points, CAMERA).tolist() == [0, 480 * 640 - 1, 640]


def test_time_to_contact_is_scored_where_it_is_short() -> None:
    seen = np.array([2.0, 6.0, np.inf, 1.0, 5.0])
    true = np.array([4.0, 5.0, 8.0, np.inf, 30.0])
    assert ttc_errors(seen, true) == pytest.approx([0.5, 0.2, 1.0])
