"""Landmarks from simulated tracks: obstacles at known places, empty roads, bends."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from driver_settings import static_obstacles
from tracked_points import CAMERA, RATE_HZ, SPEED_MPS, WINDOW_PX, Drive, body, road_points, tracker

from vpf_sim.geometry import rotation, vehicle_from_world, wrap_angles
from vpf_sim.perception.obstacles.obstacle_clusters import ObstacleClusters
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation
from vpf_sim.perception.obstacles.point_hypotheses import PointHypotheses
from vpf_sim.types import Floats, Flow, RoadEdges

BUMPER_M = 2.25  # ahead of the pose


def test_a_car_is_detected_far_away_and_measured() -> None:
    drive = Drive(np.concatenate([body(60.0, 0.3, 1.8, 1.4, 14), road_points(200)]))
    found = drive.run(tracker(), range(560))
    first = next(k for k, obstacles in enumerate(found) if len(obstacles))
    assert 60.0 - drive.pose(first)[0] > 17.0
    last = found[-1]
    assert len(last) == 1
    assert last.forward_m[0] == pytest.approx(60.0 - drive.pose(559)[0], abs=0.3)
    assert (last.left_m[0], last.right_m[0]) == pytest.approx((-0.6, 1.2), abs=0.15)
    assert last.sigma_m[0] < 0.3
    names = {int(name) for obstacles in found for name in obstacles.identity}
    assert names == {0}


@pytest.mark.parametrize(("speed_mps", "stops_from_mps"), [(14.0, 14.0), (20.0, 17.0), (25.0, 17.5)])
def test_a_fast_car_detects_farther_ahead(speed_mps: float, stops_from_mps: float) -> None:
    """In time to stop from 14 m/s; a faster one must slow down earlier or swerve."""
    drive = Drive(np.concatenate([body(100.0, 0.3, 1.8, 1.4, 14), road_points(200)]), speed_mps=speed_mps)
    found = drive.run(tracker(), range(int(95.0 / speed_mps * RATE_HZ)))
    first = next(k for k, obstacles in enumerate(found) if len(obstacles))
    stop_m = 0.3 * stops_from_mps + stops_from_mps**2 / (2.0 * 6.0)
    assert 100.0 - BUMPER_M - drive.pose(first)[0] > stop_m
    assert found[first].forward_m[0] == pytest.approx(100.0 - drive.pose(first)[0], abs=1.0)


def test_the_sides_of_a_van_are_one_obstacle_for_a_fast_car() -> None:
    """Few points are found on it from far away."""
    scene = np.array([[100.0, across, high] for across in (-0.6, 0.8) for high in (0.6, 1.1)])
    drive, speed_mps = Drive(np.concatenate([scene, road_points(100)]), speed_mps=14.0), 14.0
    seen = [one for one in drive.run(tracker(), range(int(94.0 / speed_mps * RATE_HZ))) if len(one)]
    assert seen[0].forward_m[0] > 18.0
    assert {len(one) for one in seen} == {1}
    assert (seen[0].left_m[0], seen[0].right_m[0]) == pytest.approx((-0.6, 0.8), abs=0.2)


def test_a_fast_car_sees_the_way_between_two_vehicles() -> None:
    """It is 1.9 m wide; they stand 2.6 m apart."""
    beside = [body(100.0, sign * 2.2, 1.8, 1.4, 14) for sign in (-1.0, 1.0)]
    drive = Drive(np.concatenate([*beside, road_points(100)]), speed_mps=25.0)
    seen = [one for one in drive.run(tracker(), range(int(85.0 / 25.0 * RATE_HZ))) if len(one)]
    assert {len(one) for one in seen[2:]} == {2}
    assert max(seen[-1].left_m) - min(seen[-1].right_m) == pytest.approx(2.6, abs=0.3)


@pytest.mark.parametrize(("small", "reported"), [(40.0, True), (27.0, False)])
def test_a_few_faint_points_are_no_obstacle(small: float, reported: bool) -> None:
    """The rim of a puddle and the clouds in it cross in points that slide along both; those of a cone are clearer."""
    scene = np.array([[50.0, -1.0, 0.3], [50.0, -0.8, 0.45], [50.1, -0.9, 0.6]])
    found = Drive(np.concatenate([scene, road_points(200)]), structure=small * np.eye(2)).run(tracker(), range(480))
    assert any(len(obstacles) for obstacles in found) == reported


class Slipping(Drive):
    """The whole tracks fit points that stand; their last motion is 2 px too far to the right."""

    def flow(self, frame: int) -> Flow:
        flow = super().flow(frame)
        return replace(flow, displacement_px=flow.displacement_px + np.array([2.0, 0.0]))


def test_tracks_that_slip_are_no_obstacle() -> None:
    drive = Slipping(np.concatenate([body(30.0, 0.3, 1.8, 1.4, 14), road_points(100)]))
    assert not any(len(obstacles) for obstacles in drive.run(tracker(), range(200)))


def test_faint_points_support_clear_ones() -> None:
    """A car's plain rear between its lamps."""
    scene = np.concatenate([body(60.0, 0.3, 1.8, 1.4, 14), road_points(200)])
    structure = np.tile(20.0 * np.eye(2), (len(scene), 1, 1))
    structure[[2, 11]] = 100.0 * np.eye(2)
    found = Drive(scene, structure=structure).run(tracker(), range(560))[-1]
    assert (found.left_m[0], found.right_m[0]) == pytest.approx((-0.6, 1.2), abs=0.15)


@pytest.mark.parametrize(("count", "large", "reported"), [(5, 100.0, True), (5, 600.0, False), (2, 100.0, False)])
def test_a_pedestrian_is_detected_by_the_corners_of_his_upper_half(count: int, large: float, reported: bool) -> None:
    """His legs swing and are not followed. Seen beside him the road is far away, where bends of lines slide so high up;
    and where two outlines cross a corner slides as well."""
    person = np.array([[50.0, -1.0 + 0.1 * k, 1.0 + 0.12 * k] for k in range(5)])[5 - count :]
    scene, structure = np.concatenate([person, road_points(200)]), np.diag([100.0, large])
    found = Drive(scene, structure=structure).run(tracker(), range(385))
    assert any(len(obstacles) for obstacles in found) == reported


def test_a_pedestrian_behind_and_beside_a_truck_has_his_own_identity() -> None:
    """A pedestrian 4 m behind a truck's face, 0.5 m beside its flank, of which corners are seen."""
    flank = [[40.0 + back, 0.8, high] for back in (1.5, 3.0, 4.5) for high in (0.6, 0.9)]
    person = [[44.0, across, high] for across in (0.0, 0.3) for high in (0.5, 1.2)]
    drive, found = Drive(np.concatenate([body(40.0, 2.0, 2.4, 1.4, 30), flank, person, road_points(100)])), tracker()
    looks = drive.run(found, range(370))
    first = next(k for k, look in enumerate(looks) if len(look) == 2)
    assert 40.0 - drive.pose(first)[0] > 11.2
    assert all(len(look) == 2 for look in looks[first:]), "not yet well placed, he keeps the truck's name"
    obstacles = looks[-1]
    order = np.argsort(obstacles.left_m)
    assert obstacles.left_m[order] == pytest.approx([0.0, 0.8], abs=0.15)
    assert obstacles.right_m[order] == pytest.approx([0.3, 3.2], abs=0.15)
    assert len(set(obstacles.identity.tolist())) == 2


@pytest.mark.parametrize(
    ("before", "label", "named"),
    [
        ([2, 2, 2, 2, 4, 4], [0, 0, 0, 1, 1, 1], [2, 4]),
        ([2] * 6, [0, 0, 0, 1, 1, 1], [2, 2]),
        ([2, 2, 4, 4], [0] * 4, [2]),
    ],
    ids=["a cone beside a truck", "a part of it", "two parts of one"],
)
def test_an_obstacle_keeps_its_identity_though_points_of_another_join_it(
    before: list[int], label: list[int], named: list[int]
) -> None:
    """Corners of a truck's flank are seen beside a cone: under the truck's name it would be a part of it."""
    points, one = SimpleNamespace(obstacle=np.array(before)), np.ones(len(named), np.bool_)
    obstacles = ObstacleClusters(CAMERA, static_obstacles(), cast("PointHypotheses", points), WINDOW_PX)
    assert obstacles.identify(np.arange(len(label)), np.array(label), one, one, ~one).tolist() == named
    assert points.obstacle.tolist() == [named[k] for k in label]


@pytest.mark.parametrize(("placed", "named"), [(False, -1), (True, 2)])
def test_a_badly_placed_fragment_does_not_take_the_identity(placed: bool, named: int) -> None:
    """Two of a barrier's corners, seen only from afar, seemed to stand 4 m before the car that had passed it."""
    points, both = SimpleNamespace(obstacle=np.full(6, 2)), np.ones(2, np.bool_)
    obstacles = ObstacleClusters(CAMERA, static_obstacles(), cast("PointHypotheses", points), WINDOW_PX)
    label = np.array([0, 0, 0, 0, 1, 1])
    assert obstacles.identify(np.arange(6), label, both, np.array([False, placed]), ~both).tolist() == [2, named]


@pytest.mark.parametrize(("speed_mps", "frames"), [(5.55, 20), (0.8, 60)])
def test_an_obstacle_is_reported_after_travel_of_a_share_of_its_distance(speed_mps: float, frames: int) -> None:
    """8 m ahead from the first frame on; creeping up, what moves over the glass in less would seem to stand there."""
    drive = Drive(np.concatenate([body(8.0, 0.3, 1.8, 1.4, 8), road_points(100)]), speed_mps=speed_mps)
    reported = [len(obstacles) > 0 for obstacles in drive.run(tracker(), range(frames))]
    way_m = drive.pose(reported.index(True))[0]
    assert 0.06 * 6.5 < way_m < 0.06 * 8.0 + 1.0
    assert all(reported[reported.index(True) :])


@pytest.mark.parametrize("curvature_per_m", [0.0, 0.01, -0.0125])
def test_an_empty_road_stays_empty(curvature_per_m: float) -> None:
    drive = Drive(road_points(400, curvature_per_m), noise_px=0.1, curvature_per_m=curvature_per_m)
    assert not any(len(obstacles) for obstacles in drive.run(tracker(), range(600)))


def test_objects_beside_the_carriageway_are_no_obstacles() -> None:
    beside = np.concatenate([body(40.0, 7.0, 1.0, 1.2, 6), body(45.0, -11.0, 1.0, 1.2, 6)])
    drive = Drive(np.concatenate([beside, road_points(100)]))
    assert not any(len(obstacles) for obstacles in drive.run(tracker(), range(400)))


def test_in_a_bend_the_carriageway_bends() -> None:
    curvature = 0.01
    turn = 35.0 * curvature
    ahead = np.array([np.sin(turn), 1.0 - np.cos(turn)]) / curvature  # 35 m on, in our lane
    outside = np.array([35.0, -4.0])  # straight ahead, beyond the left edge of what bends right
    across = np.column_stack([np.zeros(6), np.linspace(-0.6, 0.6, 6)])
    scene = [np.column_stack([place + across, np.linspace(0.3, 1.2, 6)]) for place in (ahead, outside)]
    drive = Drive(np.concatenate([*scene, road_points(100, curvature)]), curvature_per_m=curvature)
    drive.road = RoadEdges(-5.25, 5.25, 0.0, curvature, 0.02, 1.0, 0.0, 3.5)
    last = drive.run(tracker(), range(240))[-1]
    assert len(last) == 1
    place = vehicle_from_world(ahead, drive.pose(239))
    assert last.forward_m[0] == pytest.approx(place[0], abs=0.8)
    assert 0.5 * (last.left_m[0] + last.right_m[0]) == pytest.approx(place[1], abs=0.5)


def test_two_obstacles_in_a_row_stay_two() -> None:
    scene = [body(45.0, -2.5, 1.8, 1.4, 10), body(45.5, 2.8, 1.8, 1.4, 10), road_points(100)]
    last = Drive(np.concatenate(scene)).run(tracker(), range(380))[-1]
    assert len(last) == 2
    order = np.argsort(last.left_m)
    assert last.right_m[order[0]] < -1.4
    assert last.left_m[order[1]] > 1.7


def test_the_same_scene_turned_and_moved_in_the_world_gives_the_same_obstacles() -> None:
    """The tracker knows poses only by their differences."""
    angle, shift = 2.4, np.array([300.0, -120.0])

    def place(poses: Floats) -> Floats:
        place_m, yaw_rad = poses[..., :2] @ rotation(angle).T + shift, wrap_angles(poses[..., 2:] + angle)
        return np.concatenate([place_m, yaw_rad], axis=-1)

    drive = Drive(np.concatenate([body(40.0, 0.5, 1.8, 1.4, 10), road_points(100)]))
    here, there = tracker(), tracker()
    for frame in range(330):
        flow = drive.flow(frame)
        poses = {name: place(getattr(flow, name)) for name in ("pose", "past_pose", "first_pose")}
        turned = replace(flow, **poses)
        a, b = (
            one.update(seen, drive.road, SPEED_MPS, frame / RATE_HZ, one.triangulate(seen))
            for one, seen in ((here, flow), (there, turned))
        )
    assert len(a) == len(b) == 1
    assert a.forward_m == pytest.approx(b.forward_m, abs=1e-6)
    assert a.left_m == pytest.approx(b.left_m, abs=1e-6)


def test_low_points_under_a_narrower_tall_obstacle_are_one_with_it() -> None:
    """A pallet from 0.3 to 1.3 m: its right part was observed from afar, and alone would be 0.4 m wide."""
    tall = [[40.0, 1.0, 0.5], [40.0, 1.1, 0.45], [40.0, 1.05, 0.6]]
    low = [[41.0, 0.3, 0.15], [41.0, 0.45, 0.15], [41.0, 1.3, 0.15], [41.0, 1.2, 0.15], [41.0, 0.7, 0.15]]
    drive = Drive(np.concatenate([tall, low, road_points(100)]))
    obstacles = drive.run(tracker(), range(365))[-1]
    assert (obstacles.left_m, obstacles.right_m) == (pytest.approx([0.3], abs=0.1), pytest.approx([1.3], abs=0.1))


def test_low_points_and_a_low_track_are_one_obstacle() -> None:
    """Points at the left end of a pallet from -0.4 to 0.4 m, and a track that lies 0.2 m too far to the right."""
    low = [[40.0, -0.38, 0.15], [40.0, -0.3, 0.15], [40.3, -0.36, 0.14]]
    drive, found = Drive(np.concatenate([low, road_points(100)])), tracker()
    for k in range(355):
        obstacles = drive.run(found, range(k, k + 1))[-1]
        track = LowObservation(40.0 - drive.pose(k)[0], -0.2, 0.6, 12.0)
        if track.forward_m < 16.0 and k % 6 == 0:
            found.low_tracks.record([track], drive.pose(k))
    assert (obstacles.left_m, obstacles.right_m) == (pytest.approx([-0.4], abs=0.05), pytest.approx([0.4], abs=0.05))


def test_low_points_before_the_face_of_an_obstacle_are_another() -> None:
    """Some corners of something 2.5 m before a wide wall make one obstacle with it, whose face is the wall's."""
    wall = body(43.0, 0.0, 6.0, 1.4, 60)
    corners = [[40.5, -0.3, 0.5], [40.5, 0.3, 0.5], [41.8, 0.0, 0.9]]
    low = [[40.5, -0.2, 0.15], [40.5, 0.2, 0.15], [40.5, 0.0, 0.12]]
    points = np.concatenate([wall, corners, low, road_points(100)])
    drive, found = Drive(points), tracker()
    obstacles = drive.run(found, range(380))[-1]
    ahead = obstacles.forward_m + drive.pose(379)[0]
    assert ahead.min() == pytest.approx(40.5, abs=0.4)
