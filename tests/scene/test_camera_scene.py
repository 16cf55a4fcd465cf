"""What a camera perceives as a scene, against circles and straight lines."""

from types import SimpleNamespace
from typing import Any

import driver_settings
import numpy as np
import pytest
from made_obstacles import obstacles
from made_scene import road

from vpf_sim.driver_interface import Observation
from vpf_sim.perception.obstacles.crossing import Crossers
from vpf_sim.scene.camera import CameraScene, road_of
from vpf_sim.scene.evidence import Evidence
from vpf_sim.types import Camera, Obstacles, RoadEdges, VehicleModel

RADIUS_M, LANE_M = 60.0, 3.5
SIDES_M = (-7.0, 7.0)  # of the road's reference line


def edges_at(d_m: float, turned_rad: float, curvature_per_m: float, oncoming_m: float = 0.0) -> RoadEdges:
    """What a camera sees at `d_m`, turned to the right of the road; `curvature_per_m` is the reference line's."""
    left, right = (side - d_m for side in SIDES_M)
    here = curvature_per_m / (1.0 - curvature_per_m * d_m)
    return RoadEdges(left, right, -turned_rad, here, 0.02, 1.0, -d_m, LANE_M, 1.0, oncoming_m)


def seen(edges: RoadEdges, reported: Obstacles | None = None) -> Any:
    return SimpleNamespace(road=edges, obstacles=reported or obstacles())


AHEAD = edges_at(0.0, 0.0, 0.0)


def crosser(forward_m: float, right_m: float) -> Crossers:
    """A pedestrian, so far ahead of the camera, who walks to the left at 1.5 m/s."""
    values = forward_m, right_m - 0.3, right_m + 0.3, -1.5, 0.0, 0.3, 0.3
    return Crossers(*(np.array([value]) for value in values))


def camera_scene() -> CameraScene:
    return CameraScene(Camera(), VehicleModel(), driver_settings.scene())


def on_circle(angle_rad: float, d_m: float) -> tuple[float, float]:
    """A place right of a circle that begins at the origin along x and bends right."""
    radius = RADIUS_M - d_m
    return radius * np.sin(angle_rad), RADIUS_M - radius * np.cos(angle_rad)


def observed(x_m: float, y_m: float, yaw_rad: float, time_s: float = 0.0) -> Observation:
    return Observation(np.empty((0, 0, 3), np.uint8), time_s, x_m, y_m, yaw_rad, 5.0, 0.0, (0.0, 0.0))


@pytest.mark.parametrize("d_m", [-4.0, 0.0, 3.0])
def test_the_reference_line_of_a_bend_is_the_circle(d_m: float) -> None:
    edges = edges_at(d_m, 0.1, 1.0 / RADIUS_M)
    found = road_of(edges, np.array([*on_circle(0.2, d_m), 0.3]), 12.0)
    ahead = np.array([0.0, 10.0, 25.0])
    x, y, heading = found.world(12.0 + ahead, np.zeros(3))
    np.testing.assert_allclose(np.stack([x, y]), on_circle(0.2 + ahead / RADIUS_M, 0.0), atol=0.01)
    np.testing.assert_allclose(heading, 0.2 + ahead / RADIUS_M, atol=1e-6)


def test_places_in_the_world_and_on_the_road_are_inverse() -> None:
    bend = road(1.0 / RADIUS_M)
    s, d = np.array([3.0, 20.0, 41.3]), np.array([-5.0, 0.0, 4.0])
    x, y, _ = bend.world(s, d)
    np.testing.assert_allclose(bend.place_at(x, y, s + np.array([6.0, -6.0, 3.0])), (s, d), atol=2e-3)


def test_s_counts_the_way_along_the_reference_line() -> None:
    scene, d_m = camera_scene(), 3.0
    for angle in np.arange(0.0, 1.0, 0.01):
        scene.observe(seen(edges_at(d_m, 0.0, 1.0 / RADIUS_M)), observed(*on_circle(angle, d_m), angle))
    s, d = scene.place(observed(*on_circle(1.0, 2.0), 1.0))
    assert s == pytest.approx(RADIUS_M, abs=0.05)
    assert d == pytest.approx(2.0, abs=0.01)


def test_the_carriageway_ends_beyond_the_lanes_of_oncoming_traffic() -> None:
    edges = RoadEdges(-1.75, 1.75, 0.0, 0.0, 0.02, 1.0, 0.0, LANE_M, 1.0, oncoming_m=LANE_M)
    found = road_of(edges, np.zeros(3), 0.0)
    here = found.at(np.array([10.0]))
    assert (here.left_m[0], here.own_left_m[0], here.right_m[0]) == (-5.25, -1.75, 1.75)
    np.testing.assert_allclose(found.lanes_at(np.array([10.0])), [[0.0]])


def test_an_obstacle_keeps_its_place_in_the_world() -> None:
    """A standing car's rear 20 m ahead on a straight road, and one that drives at 4 m/s; the own car is turned."""
    turned, d_m = 0.2, 1.0
    scene = camera_scene()
    faces = np.array([[20.0, 0.5], [12.0, -3.0]]) - [0.0, d_m]  # along the road, right of the car
    forward = np.cos(turned) * faces[:, 0] + np.sin(turned) * faces[:, 1]
    aside = np.cos(turned) * faces[:, 1] - np.sin(turned) * faces[:, 0]
    places_m = np.stack([forward, aside - 0.9, aside + 0.9], axis=1).tolist()
    reported = obstacles(*places_m, identity=(3, -1), speed_mps=(0.0, 4.0))
    here = observed(0.0, d_m, turned)
    scene.observe(seen(edges_at(d_m, turned, 0.0), reported), here)
    made = scene.scene(here, 5.0)
    tracks = made.tracks
    np.testing.assert_allclose(tracks.s_m - 0.5 * tracks.length_m, [20.0, 12.0], atol=1e-6)
    np.testing.assert_allclose(tracks.d_m, [0.5, -3.0], atol=1e-6)
    np.testing.assert_allclose(tracks.y_m, [0.5, -3.0], atol=1e-6)
    np.testing.assert_allclose(tracks.heading_rad, 0.0, atol=1e-9)
    assert tracks.speed_mps.tolist() == [0.0, 4.0]
    assert (made.ego.d_m, made.road.route_m) == (d_m, 0.0)


@pytest.mark.parametrize(("relief", "reported"), [(-0.9, 0), (0.0, 1), (0.8, 1), (np.nan, 1)])
def test_what_lies_in_the_plane_of_the_road_is_no_obstacle(relief: float, reported: int) -> None:
    """Perception reports something 12 m ahead; planar parallax judges it."""
    scene = camera_scene()
    for index in range(8):
        here = observed(0.25 * index, 0.0, 0.0, index / 20.0)
        low = obstacles((12.0 - 0.25 * index, -0.4, 0.4))
        scene.observe(seen(AHEAD, low), here, Evidence(relief=np.array([relief])))
    assert len(scene.scene(here, 5.0).tracks) == reported
    assert len(scene.obstacles(here)) == reported


@pytest.mark.parametrize(("d_m", "left"), [(0.4, 0), (1.3, 1)])
def test_what_the_car_drives_over_was_none(d_m: float, left: int) -> None:
    """Something is reported 12 m ahead, in the way or beside it, until the car has driven on."""
    scene = camera_scene()
    for driven_m in np.arange(0.0, 12.0, 0.25).tolist():
        here = observed(driven_m, 0.0, 0.0, driven_m / 5.0)
        scene.observe(seen(AHEAD, obstacles((12.0 - driven_m, d_m - 0.3, d_m + 0.3), sigma_m=0.1)), here)
        if driven_m == 9.5:  # the car's front is 0.25 m before it
            assert len(scene.obstacles(here)) == 1
    assert len(scene.obstacles(here)) == left


def test_the_reported_obstacles_are_where_their_tracks_are_by_now() -> None:
    scene, lead = camera_scene(), obstacles((15.0, -0.9, 0.9), identity=[-1], speed_mps=[4.0])
    scene.observe(seen(AHEAD, lead), observed(0.0, 0.0, 0.0))
    later = scene.obstacles(observed(0.25, 0.5, 0.0, 0.05))
    assert later.forward_m[0] == pytest.approx(15.0 + 0.2 - 0.25)
    assert (later.left_m[0], later.right_m[0]) == pytest.approx((-1.4, 0.4))
    assert later.identity[0] < 0
    assert later.ttc_s[0] == pytest.approx(14.95 / (5.0 - 4.0))


@pytest.mark.parametrize(
    ("forward_m", "speed_mps", "closes"), [(15.0, 4.0, True), (15.0, 6.0, False), (-1.0, 4.0, False)]
)
def test_only_what_comes_nearer_ahead_has_a_time_to_contact(forward_m: float, speed_mps: float, closes: bool) -> None:
    scene, here = camera_scene(), observed(0.0, 0.0, 0.0)
    scene.observe(seen(AHEAD, obstacles((forward_m, 2.6, 4.4), identity=[-1], speed_mps=[speed_mps])), here)
    (ttc_s,) = scene.obstacles(here).ttc_s
    assert np.isfinite(ttc_s) == closes


def test_a_car_that_stands_finds_no_new_evidence_of_what_stands() -> None:
    """An obstacle that appears 6 m ahead, where no points judge it."""
    scene = camera_scene()
    for index in range(200):
        scene.observe(seen(AHEAD, obstacles((6.0, -0.9, 0.9))), observed(0.0, 0.0, 0.0, index / 20.0))
    assert not len(scene.scene(observed(0.0, 0.0, 0.0, 10.0), 5.0).tracks)


@pytest.mark.parametrize(("aside_m", "left"), [(0.0, 0), (4.0, 1)])
def test_what_stands_where_an_actor_crosses_is_the_actor(aside_m: float, left: int) -> None:
    """Perception keeps an obstacle 8.5 m ahead, or 4 m beside, where it saw the actor's points; then he has gone."""
    scene, face = camera_scene(), obstacles((8.5, aside_m - 0.4, aside_m + 0.4))
    for index in range(60):
        here, actor = observed(0.0, 0.0, 0.0, index / 20.0), crosser(8.0, 1.0 - 1.5 * index / 20.0)
        scene.observe(seen(AHEAD, face), here, Evidence(actor if index < 20 else None))
        if index == 15:
            assert 1.3 < scene.scene(here, 5.0).tracks.speed_mps.max() < 1.7, "and the actor stays"
    assert np.count_nonzero(scene.obstacles(here).speed_mps == 0.0) == left


def test_who_crosses_is_a_track_that_heads_across_after_some_frames() -> None:
    scene, frames = camera_scene(), 8
    for index in range(frames):
        time_s = index / 20.0
        here = observed(5.0 * time_s, 0.0, 0.0, time_s)
        scene.observe(seen(AHEAD), here, Evidence(crosser(15.0 - 5.0 * time_s, 2.0 - 1.5 * time_s)))
        if index == 0:
            assert not len(scene.scene(here, 5.0).tracks), "one frame is not enough"
    tracks = scene.scene(here, 5.0).tracks
    assert tracks.heading_rad[0] == pytest.approx(-np.pi / 2.0, abs=0.15)
    assert tracks.speed_mps[0] == pytest.approx(1.5, abs=0.2)
    assert tracks.x_m[0] == pytest.approx(15.8, abs=0.5)
    assert tracks.d_m[0] == pytest.approx(2.0 - 1.5 * (frames - 1) / 20.0, abs=0.2)
