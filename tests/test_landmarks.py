"""Landmarks from simulated tracks: bodies at known places, empty roads, bends, remembering and forgetting."""

from dataclasses import fields, replace

import numpy as np
import pytest

from vpf_sim.geometry import project, vehicle_from_world, wrap_angle
from vpf_sim.perception.carriageway import carriageway_offsets
from vpf_sim.perception.clusters import stepped
from vpf_sim.perception.landmark_config import LandmarkConfig
from vpf_sim.perception.landmarks import LandmarkTracker
from vpf_sim.perception.outlines import (
    Seen,
    at_least,
    direction_at,
    nearest_extent,
    parted,
    sides,
    stands_behind,
    turned,
    turned_back,
)
from vpf_sim.perception.triangulation import NoiseModel, information, triangulate
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow, Obstacles, RoadEdges

CAMERA = Camera()
RATE_HZ, SPEED_MPS = 60.0, 5.55
ANCHOR_FRAMES = 42


class Drive:
    """A car on the x axis, or on a circle, and standing points (N, 3), tracked while seen, with renewed anchors."""

    def __init__(self, scene_m: Floats, noise_px: float = 0.05, curvature_per_m: float = 0.0) -> None:
        self.scene, self.noise_px, self.curvature = scene_m, noise_px, curvature_per_m
        self.rng = stream(21, "landmarks")
        self.first_px = np.full((len(scene_m), 2), np.nan)
        self.first_pose = np.zeros((len(scene_m), 3))
        self.age = np.zeros(len(scene_m), np.int64)
        self.trail: list[tuple[Floats, Floats]] = []  # image points and pose of the last frames
        self.road = RoadEdges(-8.75, 5.25, 0.0, curvature_per_m, 0.02, 1.0, 0.0, 3.5)

    def pose(self, frame: int) -> Floats:
        way = frame * SPEED_MPS / RATE_HZ
        if self.curvature == 0.0:
            return np.array([way, 0.0, 0.0])
        turn = way * self.curvature
        return np.array([np.sin(turn), 1.0 - np.cos(turn), turn * self.curvature]) / self.curvature

    def flow(self, frame: int) -> Flow:
        pose = self.pose(frame)
        place = vehicle_from_world(self.scene[:, :2], pose)
        seen = project(CAMERA, np.column_stack([place, self.scene[:, 2]]))
        seen = seen + self.rng.normal(0.0, self.noise_px, seen.shape)
        visible = (place[:, 0] > 2.0) & (place[:, 0] < 60.0) & np.all((seen > 5.0) & (seen < [634.0, 474.0]), axis=1)
        new = visible & np.isnan(self.first_px[:, 0])
        self.first_px[new], self.first_pose[new] = seen[new], pose
        self.age[visible & ~new] += 1
        self.trail = [*self.trail[-ANCHOR_FRAMES:], (seen, pose)]
        renewed = self.age >= 2 * ANCHOR_FRAMES
        self.first_px[renewed], self.first_pose[renewed] = self.trail[0][0][renewed], self.trail[0][1]
        self.age[renewed] = ANCHOR_FRAMES
        old = np.flatnonzero(visible & (self.age >= 6))
        past, past_pose = self.trail[max(0, len(self.trail) - 7)]
        count = len(old)
        return Flow(
            points_px=seen[old],
            displacement_px=seen[old] - past[old],
            gap_s=np.full(count, 0.1),
            past_pose=np.tile(past_pose, (count, 1)),
            pose=pose,
            identity=old.astype(np.int64),
            first_px=self.first_px[old],
            first_pose=self.first_pose[old],
            age_frames=self.age[old],
            structure=np.tile(100.0 * np.eye(2), (count, 1, 1)),
        )

    def run(self, tracker: LandmarkTracker, frames: range) -> list[Obstacles]:
        return [tracker.update(self.flow(k), self.road, SPEED_MPS, k / RATE_HZ) for k in frames]


def body(forward_m: float, right_m: float, width_m: float, height_m: float, count: int) -> Floats:
    rng = stream(22, f"body {forward_m}")
    across = right_m + width_m * np.linspace(-0.5, 0.5, count)
    return np.column_stack([np.full(count, forward_m), across, rng.uniform(0.3, height_m, count)])


def road_points(count: int, curvature_per_m: float = 0.0) -> Floats:
    rng = stream(23, "road")
    along, aside = rng.uniform(5.0, 120.0, count), rng.uniform(-8.0, 5.0, count)
    if curvature_per_m == 0.0:
        return np.column_stack([along, aside, np.zeros(count)])
    turn, radius = along * curvature_per_m, 1.0 / curvature_per_m
    return np.column_stack([(radius - aside) * np.sin(turn), radius - (radius - aside) * np.cos(turn), np.zeros(count)])


def tracker() -> LandmarkTracker:
    return LandmarkTracker(CAMERA, LandmarkConfig(), RATE_HZ)


def test_depth_and_height_are_exact_without_noise() -> None:
    drive = Drive(np.array([[30.0, 1.0, 0.7], [25.0, -2.0, 0.0], [28.0, 0.5, 2.0]]), 0.0, curvature_per_m=0.004)
    for frame in range(40):
        flow = drive.flow(frame)
    points = triangulate(flow, CAMERA, 11, flow.age_frames / RATE_HZ, NoiseModel())
    place = vehicle_from_world(drive.scene[:, :2], flow.pose)
    assert points.depth_m == pytest.approx(place[:, 0] - CAMERA.forward_m, abs=1e-6)
    assert points.right_m == pytest.approx(place[:, 1], abs=1e-6)
    assert points.height_m == pytest.approx(drive.scene[:, 2], abs=1e-6)
    assert points.chi2 == pytest.approx(0.0, abs=1e-6)
    assert points.chi2_ground[1] == pytest.approx(0.0, abs=1e-6)
    assert points.chi2_ground[0] > 5.0
    assert np.isinf(points.chi2_ground[2])  # above the horizon there is no road


def test_the_sigma_of_the_depth_is_that_of_the_errors() -> None:
    """chi2 and z-scores of many noisy points: the noise model is given the noise that was added."""
    rng = stream(24, "sigma")
    scene = np.column_stack([np.full(400, 20.0), rng.uniform(-6.0, 4.0, 400), rng.uniform(0.2, 1.0, 400)])
    drive = Drive(scene, noise_px=0.1)
    for frame in range(31):
        flow = drive.flow(frame)
    # Both sightings are noisy, the model speaks of their difference: floor^2 growth = 2 x 0.1^2.
    points = triangulate(flow, CAMERA, 11, np.zeros(len(flow)), NoiseModel(0.0, 0.1 * np.sqrt(2.0), pitch_rad=0.0))
    error = points.depth_m - (20.0 - flow.pose[0] - CAMERA.forward_m)
    assert np.std(error / points.sigma_m) == pytest.approx(1.0, abs=0.25)
    assert np.mean(points.chi2) == pytest.approx(1.0, abs=0.3)  # two equations, one unknown


def test_an_edge_gives_no_information_along_itself() -> None:
    flow = Drive(np.array([[20.0, 1.0, 0.5]])).flow(0)
    direction = np.array([0.6, 0.8])
    tensor = 400.0 * np.outer(direction, direction) + 0.1 * np.eye(2)
    one = Flow(
        *(np.zeros((1, 2)) if name in ("points_px", "displacement_px", "first_px") else getattr(flow, name) for name in
          ("points_px", "displacement_px", "gap_s", "past_pose", "pose", "identity", "first_px", "first_pose",
           "age_frames")),
        structure=tensor[None],
    )  # fmt: skip
    weight = information(one, 11, np.zeros(1), NoiseModel())[0]
    along = np.array([-0.8, 0.6])
    assert along @ weight @ along < 1e-2 * (direction @ weight @ direction)


def test_a_car_is_found_far_off_and_measured() -> None:
    drive = Drive(np.concatenate([body(60.0, 0.3, 1.8, 1.4, 14), road_points(200)]))
    found = drive.run(tracker(), range(560))
    first = next(k for k, bodies in enumerate(found) if len(bodies))
    assert 60.0 - drive.pose(first)[0] > 17.0
    last = found[-1]
    assert len(last) == 1
    assert last.forward_m[0] == pytest.approx(60.0 - drive.pose(559)[0], abs=0.3)
    assert (last.left_m[0], last.right_m[0]) == pytest.approx((-0.6, 1.2), abs=0.15)
    assert last.ttc_s[0] == pytest.approx(last.forward_m[0] / SPEED_MPS)
    assert last.sigma_m[0] < 0.3
    names = {int(name) for bodies in found for name in bodies.identity}
    assert names == {0}


def test_one_corner_is_enough_for_a_cone() -> None:
    drive = Drive(np.concatenate([[[50.0, -1.0, 0.5]], road_points(200)]))
    found = drive.run(tracker(), range(500))
    first = next(k for k, bodies in enumerate(found) if len(bodies))
    assert 50.0 - drive.pose(first)[0] > 10.0


@pytest.mark.parametrize(("count", "kept"), [(3, 0), (12, 1)])
def test_a_look_at_the_road_does_not_clear_a_body_that_many_points_tell(count: int, kept: int) -> None:
    drive, found = Drive(np.concatenate([body(40.0, 0.3, 1.8, 1.4, count), road_points(100)])), tracker()
    bodies = drive.run(found, range(330))[-1]
    assert len(bodies) == 1
    found._clear(bodies, 0, drive.pose(329))
    assert len(drive.run(found, range(330, 334))[-1]) == kept


def test_the_corner_of_a_shadow_and_a_wheel_are_no_body_beside_the_car() -> None:
    """A car's face and flank, low points of its wheel, and one 0.8 m beside these that seems to stand 0.1 m high."""
    face = body(40.0, 3.0, 2.0, 1.4, 10)
    flank = [[along, 2.0, 0.6] for along in (42.0, 44.0, 44.3)]
    low = np.array([[44.2, 2.0, 0.15], [44.1, 1.2, 0.1]])
    found = Drive(np.concatenate([face, flank, low, road_points(100)])).run(tracker(), range(400))
    assert all(len(bodies) <= 1 and bodies.left_m.min(initial=2.0) > 1.7 for bodies in found)
    assert len(found[-1]) == 1
    alone = Drive(np.concatenate([low, road_points(100)])).run(tracker(), range(430))
    assert any(len(bodies) for bodies in alone), "without the car they are a pallet"


@pytest.mark.parametrize("curvature_per_m", [0.0, 0.01, -0.0125])
def test_an_empty_road_stays_empty(curvature_per_m: float) -> None:
    drive = Drive(road_points(400, curvature_per_m), noise_px=0.1, curvature_per_m=curvature_per_m)
    assert not any(len(bodies) for bodies in drive.run(tracker(), range(600)))


def test_what_stands_beside_the_carriageway_is_no_obstacle() -> None:
    beside = np.concatenate([body(40.0, 7.0, 1.0, 1.2, 6), body(45.0, -11.0, 1.0, 1.2, 6)])
    drive = Drive(np.concatenate([beside, road_points(100)]))
    assert not any(len(bodies) for bodies in drive.run(tracker(), range(400)))


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


def test_a_body_is_remembered_out_of_view_and_forgotten_once_passed() -> None:
    drive = Drive(np.concatenate([body(30.0, 2.5, 1.6, 1.3, 10), road_points(100)]))
    found = drive.run(tracker(), range(480))
    beside = next(k for k in range(480) if drive.pose(k)[0] > 30.0)
    assert len(found[beside]) == 1
    assert found[beside].forward_m[0] == pytest.approx(0.0, abs=0.3)
    assert np.isinf(found[beside + 30].ttc_s[0])
    passed = next(k for k in range(480) if drive.pose(k)[0] > 41.6)
    assert not len(found[passed])


def test_a_lost_track_clears_nothing() -> None:
    drive = Drive(np.concatenate([body(40.0, 0.0, 1.8, 1.4, 10), road_points(100)]))
    watch = tracker()
    seen = drive.run(watch, range(280))
    assert len(seen[-1]) == 1
    drive.scene = np.concatenate([np.tile([-50.0, 0.0, 0.0], (10, 1)), drive.scene[10:]])
    later = drive.run(watch, range(280, 400))
    assert all(len(bodies) == 1 for bodies in later)
    assert later[-1].forward_m[0] == pytest.approx(40.0 - drive.pose(399)[0], abs=0.5)


def test_two_bodies_in_a_row_stay_two() -> None:
    scene = [body(45.0, -2.5, 1.8, 1.4, 10), body(45.5, 2.8, 1.8, 1.4, 10), road_points(100)]
    last = Drive(np.concatenate(scene)).run(tracker(), range(380))[-1]
    assert len(last) == 2
    order = np.argsort(last.left_m)
    assert last.right_m[order[0]] < -1.4
    assert last.left_m[order[1]] > 1.7


def test_a_side_known_well_across_counts_however_poor_its_depth() -> None:
    """A barrier ahead is lost 16 m before it, and joined to a car beside it that is measured ever better."""
    barrier, car = body(42.0, 0.2, 3.0, 1.0, 12), body(40.5, 2.9, 2.0, 1.4, 12)
    drive, found = Drive(np.concatenate([barrier, car])), tracker()
    for frame in range(round(31.0 / SPEED_MPS * RATE_HZ)):
        flow = drive.flow(frame)
        kept = (flow.identity >= len(barrier)) | (flow.pose[0] < 26.0)
        seen = found.update(chosen(flow, kept), drive.road, SPEED_MPS, frame / RATE_HZ)
    assert seen.left_m.min() == pytest.approx(-1.3, abs=0.2)
    assert seen.right_m.max() == pytest.approx(3.9, abs=0.2)


def test_what_lies_before_the_face_is_moved_along_its_line_of_sight() -> None:
    """A corner 12 m ahead and 3 m right, seen from the origin and placed at two thirds of its distance; then a turn."""
    turn, corner = -0.3, np.array([12.0, 3.0])
    placed = vehicle_from_world(np.stack([corner * 2.0 / 3.0, corner]), np.array([0.0, 0.0, turn]))
    sight = np.arctan2(corner[1], corner[0]) - turn
    across = at_least(np.full(2, placed[1, 0]), placed, np.full(2, sight))
    assert across == pytest.approx([placed[1, 1]] * 2)


def chosen(flow: Flow, kept: Bools) -> Flow:
    """The flow of some of its points."""
    columns = {field.name: getattr(flow, field.name) for field in fields(flow)}
    return Flow(**{name: column if name == "pose" else column[kept] for name, column in columns.items()})


def test_the_same_scene_turned_and_moved_in_the_world_gives_the_same_bodies() -> None:
    """The tracker knows poses only by their differences."""
    angle, shift = 2.4, np.array([300.0, -120.0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def place(poses: Floats) -> Floats:
        yaw = np.array([wrap_angle(float(value)) for value in np.atleast_1d(poses[..., 2] + angle)])
        return np.concatenate([poses[..., :2] @ turn.T + shift, yaw.reshape((*poses.shape[:-1], 1))], axis=-1)

    drive = Drive(np.concatenate([body(40.0, 0.5, 1.8, 1.4, 10), road_points(100)]))
    here, there = tracker(), tracker()
    for frame in range(330):
        flow = drive.flow(frame)
        turned = Flow(
            *(
                place(getattr(flow, name)) if name in ("pose", "past_pose", "first_pose") else getattr(flow, name)
                for name in Flow.__slots__
            )
        )
        a = here.update(flow, drive.road, SPEED_MPS, frame / RATE_HZ)
        b = there.update(turned, drive.road, SPEED_MPS, frame / RATE_HZ)
    assert len(a) == len(b) == 1
    assert a.forward_m == pytest.approx(b.forward_m, abs=1e-6)
    assert a.left_m == pytest.approx(b.left_m, abs=1e-6)


def test_the_edges_of_the_carriageway_follow_heading_and_curvature() -> None:
    road = RoadEdges(-7.0, 7.0, 0.05, 0.01, 0.02, 1.0, 1.75, 3.5)
    left, right = carriageway_offsets(np.array([0.0, 20.0]), road)
    assert (left[0], right[0]) == pytest.approx((-7.0, 7.0), abs=0.02)
    # On circles about (x, y) = 100 m to the right of the pose, turned by the heading.
    centre = 100.0 * np.array([-np.sin(0.05), np.cos(0.05)])
    for offset, found in ((-7.0, left[1]), (7.0, right[1])):
        exact = centre[1] - np.sqrt((100.0 - offset) ** 2 - (20.0 - centre[0]) ** 2)
        assert found == pytest.approx(exact, abs=0.15)


def test_nonsense_is_refused_with_what_was_given() -> None:
    with pytest.raises(ValueError, match=r"expected 0 < near < far, got 30\.0, 28\.0"):
        LandmarkConfig(near_m=30.0)


def test_a_face_is_told_by_a_share_of_its_points_not_by_the_nearest() -> None:
    """200 bodies of 8 points each, known to 1.2 m, which errs by -1.7 m for the nearest of 8; then with 2 points of the
    side 3 m behind the face, known better."""
    rng, count = stream(25, "faces"), 200
    forward = np.concatenate([rng.normal(20.0, 1.2, 8 * count), rng.normal(23.0, 0.5, count)])
    label = np.concatenate([np.repeat(np.arange(count), 8), np.repeat(np.arange(count // 2, count), 2)])
    sigma = np.concatenate([np.full(8 * count, 1.2), np.full(count, 0.5)])
    some = np.zeros_like(forward)
    face, face_sigma = nearest_extent(Seen(np.column_stack([forward, some]), sigma, some, some), label, count)
    alone, followed = face[: count // 2] - 20.0, face[count // 2 :] - 20.0
    assert -1.0 < np.mean(alone) < 0.0
    assert np.mean(np.abs(alone) < 1.5) > 0.9
    assert np.all(face_sigma < 0.5)
    assert np.mean(np.abs(followed) < 1.5) > 0.9


def test_a_long_body_along_the_road_is_as_wide_as_its_face_whichever_way_the_car_is_turned() -> None:
    """A truck of 2.5 x 9 m whose points err along the line of sight: 0.03 m on the face, 0.6 m on the roof."""
    rng, heading_rad = stream(26, "sides"), 0.3
    face = np.column_stack([np.full(40, 12.0), rng.uniform(-1.0, 1.5, 40)])
    side = np.column_stack([rng.uniform(12.0, 21.0, 20), np.full(20, -1.0)])
    roof = np.column_stack([rng.uniform(12.0, 21.0, 20), rng.uniform(-1.0, 1.5, 20)])
    turn = np.array([[np.cos(heading_rad), np.sin(heading_rad)], [-np.sin(heading_rad), np.cos(heading_rad)]])
    place = np.concatenate([face, side, roof]) @ turn
    sigma = np.repeat([0.03, 0.03, 0.6], [40, 20, 20])
    sight = np.arctan2(place[:, 1], place[:, 0])
    place = place + (sigma * rng.standard_normal(80))[:, None] * np.column_stack([np.cos(sight), np.sin(sight)])
    road = RoadEdges(-7.0, 7.0, heading_rad, 0.0, 0.02, 1.0, 0.0, 3.5)
    label, seen = np.zeros(80, np.int64), Seen(place, sigma, sight, np.zeros(80))
    angle = direction_at(seen, label, 1, road)
    seen = turned(seen, angle[label])
    begin, _ = nearest_extent(seen, label, 1)
    forward, left, right = turned_back(begin, *sides(seen, label, begin, 0.12), angle)
    assert right[0] - left[0] == pytest.approx(2.5, abs=0.3)
    middle = turn @ [forward[0], 0.5 * (left[0] + right[0])]
    assert middle == pytest.approx([12.0, 0.25], abs=0.2)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_shows_beside_a_body_farther_away_does_not_make_it_wider(side: float) -> None:
    """A car's face from 1 m left to 1 m right of the axis, 12 m ahead, and points that slide along its far edge; the
    points on a side that is turned to the camera are where they seem."""
    face = np.array([[12.0, across] for across in np.linspace(-1.0, 1.0, 9)])
    slides = np.array([[depth, side * depth / 12.0] for depth in (20.0, 16.0, 14.0, 13.0)])
    place = np.concatenate([face, slides])
    seen = points(place)
    left, right = sides(seen, np.zeros(len(place), np.int64), np.array([12.0]), 0.12)
    assert (left[0], right[0]) == pytest.approx((-1.0, 1.0), abs=1e-9)
    near_side = np.array([[12.0, 3.0 * side], [12.0, 5.0 * side], [16.0, 3.0 * side], [19.0, 3.0 * side]])
    left, right = sides(points(near_side), np.zeros(4, np.int64), np.array([12.0]), 0.12)
    assert sorted((side * left[0], side * right[0])) == pytest.approx([3.0, 5.0], abs=1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_was_seen_from_afar_beside_an_edge_does_not_move_it(side: float) -> None:
    """A car's face between 1 and 3 m aside, seen from 8 m; from 20 m a point was told 0.5 m beside its outer edge, as
    far as half a window reaches there, and those of a barrier that has not been seen since."""
    face = [(8.0, side * across) for across in np.linspace(1.0, 3.0, 9)]
    place = np.array([*face, (8.0, side * 3.5), (8.0, side * 5.0), (8.0, side * 6.0)])
    rim = np.repeat([0.14, 0.35], [9, 3])
    for count, outer in ((10, 3.0), (12, 6.0)):
        seen = replace(points(place[:count], 0.01), rim_m=rim[:count])
        found = sides(seen, np.zeros(count, np.int64), np.array([8.0]), 0.12)
        assert sorted(side * edge[0] for edge in found) == pytest.approx([1.0, outer], abs=1e-9)


def points(place_m: Floats, sigma_m: float = 0.1) -> Seen:
    """Points (N, 2) in vehicle axes, seen sharply from the origin."""
    count = len(place_m)
    return Seen(place_m, np.full(count, sigma_m), np.arctan2(place_m[:, 1], place_m[:, 0]), np.zeros(count))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_who_stands_behind_a_body_and_beside_it_is_a_body_of_its_own(side: float) -> None:
    """A van on one side, its flank turned to the camera, what slides along its outer edge, and a pedestrian."""
    face = [(8.0, side * across) for across in (3.0, 3.5, 4.0, 4.5, 5.0)]
    flank = [(forward, side * 3.0) for forward in (9.5, 11.0, 12.5)]
    slides = [(14.0, side * 5.0 * 14.0 / 8.0)]
    pedestrian = [(11.0, side * 1.2), (11.0, side * 1.6), (11.1, side * 1.4)]
    place = np.array(face + flank + slides + pedestrian)
    seen = points(place)
    label = np.zeros(len(place), np.int64)
    behind = stands_behind(seen, label, 1)
    assert behind.tolist() == [False] * 9 + [True] * 3
    assert not stands_behind(replace(seen, sigma_m=np.full(len(place), 1.5)), label, 1).any(), "depth known badly"
    parts, apart = stepped(label, behind, lambda parts: np.ones(parts.max() + 1, np.bool_))
    assert parts.tolist() == [0] * 9 + [1] * 3
    assert apart.tolist() == [False, True]
    parts, apart = stepped(label, behind, lambda parts: np.arange(parts.max() + 1) == 0)
    assert parts.tolist() == [0] * 12, "what would be no body by itself stays a part of the other"
    assert apart.tolist() == [False]


@pytest.mark.parametrize(
    ("ahead_m", "across_m", "body", "support", "own"),
    [
        (15.0, (-3.6, -3.4), 4, 1, False),  # one point beside the van, once taken for a part of it
        (15.0, (-3.6, -3.4), 4, 3, True),  # several are a body
        (15.0, (-3.6, -3.4), 5, 1, True),  # and so is one of another
        (12.0, (-6.5, -5.5), 4, 3, False),  # in the strip that the van hides
        (9.0, (-2.2, -1.8), 4, 3, False),  # along its side
        (16.0, (-2.2, -1.8), 4, 3, True),  # beyond it
        (4.5, (-5.5, -5.5), 4, 1, True),  # its own side
        (4.5, (-2.5, -0.5), 4, 3, True),
        (3.0, (-3.0, -2.5), 4, 3, True),  # nothing nearer hides it, and it hides not the larger
    ],
)
def test_what_parted_from_a_body_behind_it_is_no_other(
    ahead_m: float, across_m: tuple[float, float], body: int, support: int, own: bool
) -> None:
    """A van 4 m ahead, from 4 to 2 m left of the camera's axis, has the number 4."""
    left, right = np.array([-4.0, across_m[0]]), np.array([-2.0, across_m[1]])
    is_part = parted(np.array([4.0, ahead_m]), left, right, np.array([4, body]), np.array([20, support]))
    assert is_part.tolist() == [False, not own]


def test_what_lies_low_before_the_face_that_is_told_of_a_body_is_not_of_that_body() -> None:
    """Some corners of something 2.5 m before a wide wall make one body with it, whose face is the wall's."""
    wall = body(43.0, 0.0, 6.0, 1.4, 60)
    corners = [[40.5, -0.3, 0.5], [40.5, 0.3, 0.5], [41.8, 0.0, 0.9]]
    low = [[40.5, -0.2, 0.15], [40.5, 0.2, 0.15], [40.5, 0.0, 0.12]]
    points = np.concatenate([wall, corners, low, road_points(100)])
    drive, found = Drive(points), tracker()
    bodies = drive.run(found, range(380))[-1]
    ahead = bodies.forward_m + drive.pose(379)[0]
    assert ahead.min() == pytest.approx(40.5, abs=0.4)
