"""Moving vehicles from simulated point tracks: boxes on wheels at known places and speeds beside what stands."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import moving_obstacles
from tracked_points import CAMERA, RATE_HZ, SPEED_MPS, WINDOW_PX, Drive, Traffic, body, road_points, tracker

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.obstacles.moving.detection import measure
from vpf_sim.perception.obstacles.moving.merging import merged
from vpf_sim.perception.obstacles.moving.moving_frame import Course, against
from vpf_sim.perception.obstacles.moving.track import Detection, MovingTrack
from vpf_sim.perception.obstacles.moving.tracker import MovingObstacleTracker
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Flow, Obstacles


def vehicle(forward_m: float, right_m: float, count: int = 16, width_m: float = 1.8) -> Floats:
    """The rear of a car: points on it, and the lowest corners of its tyres that can be followed."""
    rng = stream(31, f"vehicle {forward_m} {right_m}")
    across = right_m + width_m * np.linspace(-0.5, 0.5, count)
    rear = np.column_stack([np.full(count, forward_m), across, rng.uniform(0.2, 1.4, count)])
    feet = [[forward_m, right_m + side * 0.5 * width_m, 0.12] for side in (-1.0, 1.0)]
    return np.concatenate([feet, rear])


def believed(
    place_m: tuple[float, float, float],
    speed_mps: float,
    pose: Floats,
    identity: int | None = None,
    odds: float = 5.0,
    sigma_mps: float = 0.5,
) -> MovingTrack:
    """A track at a depth, with its left and right side; confirmed where it has an identity."""
    depth, left, right = place_m
    sight = Detection(depth, speed_mps, sigma_mps, left, right)
    track = MovingTrack(sight, CAMERA, pose, odds, moving_obstacles().filter)
    track.identity = identity
    return track


class Seen:
    """Both obstacle trackers together, as the planner has them."""

    def __init__(self) -> None:
        self.moving = MovingObstacleTracker(CAMERA, moving_obstacles(), RATE_HZ, WINDOW_PX, NoiseModel())
        self.static = tracker()

    def run(self, drive: Drive, frames: range) -> list[Obstacles]:
        found = []
        for frame in frames:
            flow, time_s = drive.flow(frame), frame / RATE_HZ
            points = self.static.triangulate(flow)
            moving = self.moving.update(flow, points, drive.road, SPEED_MPS, time_s)
            standing = self.static.update(flow, drive.road, SPEED_MPS, time_s, points, moving)
            found.append(standing.concatenate(self.moving.moving(flow.pose)))
        return found


def traffic(*obstacles: tuple[Floats, float], noise_px: float = 0.05) -> Traffic:
    road = road_points(400)
    parts = [*obstacles, (road[road[:, 1] < -4.5], 0.0)]  # where no body hides it
    speeds = np.concatenate([np.full(len(points), speed) for points, speed in parts])
    return Traffic(np.concatenate([points for points, _ in parts]), speeds, noise_px)


@pytest.mark.parametrize("speed_mps", [3.0, 5.0, 9.0])
def test_a_moving_vehicle_has_the_inverse_depth_of_its_closing_speed(speed_mps: float) -> None:
    drive = traffic((vehicle(20.0, 1.0), speed_mps), noise_px=0.0)
    for frame in range(40):
        flow = drive.flow(frame)
    points = tracker().triangulate(flow)
    seen = measure(flow, points, CAMERA, RATE_HZ, moving_obstacles())
    mine = flow.identity < 18
    depth = 20.0 + (speed_mps - SPEED_MPS) * 39 / RATE_HZ - CAMERA.forward_m
    assert seen.inverse_per_m[mine] == pytest.approx((1.0 - speed_mps / SPEED_MPS) / depth, abs=1e-6)
    assert seen.own_mps[mine] == pytest.approx(SPEED_MPS, abs=1e-6)
    assert seen.moves[flow.identity < 2].all()
    assert not seen.moves[~mine].any()


@pytest.mark.parametrize(("start_m", "speed_mps", "seconds"), [(30.0, 3.0, 5.0), (16.0, 4.8, 3.0), (9.0, 9.0, 2.5)])
def test_a_lead_car_is_found_at_its_place_with_its_speed(start_m: float, speed_mps: float, seconds: float) -> None:
    drive = traffic((vehicle(start_m, 0.4), speed_mps))
    found = Seen().run(drive, range(round(seconds * RATE_HZ)))
    first, last = next(k for k, one in enumerate(found) if len(one)), found[-1]
    assert start_m != 30.0 or start_m + (speed_mps - SPEED_MPS) * first / RATE_HZ > 20.0, "far off"
    assert len(last) == 1
    true_m = start_m + (speed_mps - SPEED_MPS) * (len(found) - 1) / RATE_HZ
    assert last.forward_m[0] == pytest.approx(true_m, rel=0.06)
    assert last.speed_mps[0] == pytest.approx(speed_mps, abs=0.6)
    assert (last.left_m[0], last.right_m[0]) == pytest.approx((-0.5, 1.3), abs=0.35)
    assert {int(name) for obstacles in found for name in obstacles.identity} == {-1}


def test_what_stands_does_not_move() -> None:
    drive = traffic((body(45.0, -3.0, 1.8, 1.4, 12), 0.0), (body(50.0, 0.5, 1.0, 1.0, 8), 0.0), noise_px=0.1)
    found = Seen().run(drive, range(400))
    assert all((obstacles.identity >= 0).all() for obstacles in found)
    assert len(found[-1]) == 2
    assert not found[-1].speed_mps.any()


def test_the_mirror_image_of_a_standing_car_does_not_move() -> None:
    """The mirror image of a standing car is seen as points below the road, at the car's distance."""
    rear = body(45.0, 0.0, 1.8, 1.4, 14)
    mirror = rear * [1.0, 1.0, -1.0]
    found = Seen().run(traffic((rear, 0.0), (mirror, 0.0)), range(420))
    assert all((obstacles.identity >= 0).all() for obstacles in found)
    assert found[-1].forward_m == pytest.approx([45.0 - SPEED_MPS * 419 / RATE_HZ], abs=0.4)


def test_a_standing_cone_beside_a_moving_car_is_still_found() -> None:
    cone = [[33.0, 2.6, height] for height in (0.4, 0.5, 0.6)]
    found = Seen().run(traffic((vehicle(14.0, 0.0), 4.5), (np.array(cone), 0.0)), range(240))
    assert sorted(np.sign(found[-1].identity + 0.5)) == [-1.0, 1.0]


def test_a_vehicle_is_predicted_while_it_is_passed_and_then_pruned() -> None:
    """Its wheels are still seen when its face has left the picture; they must not hold it back."""
    side = np.column_stack(
        [14.0 + np.repeat([1.0, 3.7], 6), np.full(12, 2.3), np.tile([0.0, 0.1, 0.3, 0.5, 0.6, 0.9], 2)]
    )
    drive = traffic((np.concatenate([vehicle(14.0, 3.2), side]), 3.0))
    found = Seen().run(drive, range(round(18.0 * RATE_HZ)))
    beside = round((14.0 + 2.0) / (SPEED_MPS - 3.0) * RATE_HZ)  # its face is 2 m behind us
    assert len(found[beside]) == 1
    assert found[beside].forward_m[0] == pytest.approx(-2.0, abs=1.5)
    assert not len(found[-1])


def test_a_faster_vehicle_is_tracked_from_beside_to_ahead() -> None:
    """It is seen from when its face is in the picture; its place and speed are those it has."""
    drive = traffic((vehicle(5.0, 3.2), 9.0))
    found = Seen().run(drive, range(round(4.0 * RATE_HZ)))
    confirmed = [k for k, obstacles in enumerate(found) if len(obstacles)]
    last = found[-1]
    assert confirmed[0] < 2.5 * RATE_HZ
    assert last.forward_m[0] == pytest.approx(5.0 + (9.0 - SPEED_MPS) * (len(found) - 1) / RATE_HZ, rel=0.08)
    assert last.speed_mps[0] == pytest.approx(9.0, abs=0.8)
    assert 0.5 * (last.left_m[0] + last.right_m[0]) == pytest.approx(3.2, abs=0.5)


class Contrasted(Traffic):
    """Traffic whose points have a squared contrast each, as a share of 1."""

    def __init__(self, scene_m: Floats, speed_mps: Floats, contrast: Floats) -> None:
        super().__init__(scene_m, speed_mps)
        self.contrast = contrast

    def flow(self, frame: int) -> Flow:
        flow: Flow = super().flow(frame)
        return replace(flow, structure=flow.structure * self.contrast[flow.identity][:, None, None])


def before_trees(contrast: float) -> Contrasted:
    """A car at 14 m that drives at 3 m/s, before a row of trees with just its inverse depth, as it is a second on."""
    car = vehicle(14.0, 3.2)
    rng = stream(33, "trees")
    depth = (14.0 - CAMERA.forward_m + 3.0 - SPEED_MPS) / (1.0 - 3.0 / SPEED_MPS) + SPEED_MPS
    trees = np.column_stack(
        [np.full(60, depth + CAMERA.forward_m), rng.uniform(4.0, 15.0, 60), rng.uniform(1.6, 7.0, 60)]
    )
    speeds, contrasts = np.repeat([[3.0, 0.0], [contrast, 1.0]], [len(car), len(trees)], axis=1)
    return Contrasted(np.concatenate([car, trees]), speeds, contrasts)


def test_trees_behind_a_vehicle_that_share_its_flow_do_not_hide_it() -> None:
    found = Seen().run(before_trees(1.0), range(round(1.5 * RATE_HZ)))
    last = found[-1]
    assert np.count_nonzero(last.identity < 0) == 1
    track = int(np.argmin(last.identity))
    assert last.forward_m[track] == pytest.approx(14.0 + (3.0 - SPEED_MPS) * (len(found) - 1) / RATE_HZ, rel=0.08)
    assert (last.left_m[track], last.right_m[track]) == pytest.approx((2.3, 4.1), abs=0.5)


def test_an_image_as_faint_as_a_wet_road_mirrors_is_no_vehicle() -> None:
    found = Seen().run(before_trees(0.1), range(round(1.5 * RATE_HZ)))
    assert not any((obstacles.identity < 0).any() for obstacles in found)


def test_a_confirmed_track_keeps_its_place_against_a_nearer_tentative_one() -> None:
    """Both explain the same points with the same time to contact."""
    drive = traffic((vehicle(16.0, 0.0), 3.0))
    seen = Seen()
    seen.run(drive, range(round(2.0 * RATE_HZ)))
    (track,) = [track for track in seen.moving.tracks if track.identity is not None]
    pose = drive.pose(round(2.0 * RATE_HZ) - 1)
    place_m = track.place(pose)[0] - 3.0, -1.2, 1.2
    seen.moving.tracks.append(believed(place_m, 3.6, pose, odds=0.9))
    found = seen.run(drive, range(round(2.0 * RATE_HZ), round(2.2 * RATE_HZ)))
    assert [int(name) for name in found[-1].identity] == [-1]
    expected = 16.0 + (3.0 - SPEED_MPS) * 2.2
    assert found[-1].forward_m == pytest.approx([expected], abs=0.6)


def two(ahead_m: float, right_m: float, pose: Floats) -> list[MovingTrack]:
    """Two confirmed tracks on a road along the x axis, the second so far ahead of the first and right of it."""
    tracks = []
    for name, (x, y) in enumerate([(12.0, 0.0), (12.0 + ahead_m, right_m)], start=1):
        forward, right = vehicle_from_world(np.array([x, y]), pose)
        place_m = float(forward) - CAMERA.forward_m, float(right) - 1.0, float(right) + 1.0
        tracks.append(believed(place_m, 3.0, pose, name))
        tracks[-1].predict(0.0, 0.0, 0.0)
    return tracks


@pytest.mark.parametrize(("ahead_m", "right_m", "count"), [(4.0, 3.5, 2), (4.0, -3.5, 2), (4.0, 0.0, 1), (0.0, 2.0, 1)])
@pytest.mark.parametrize("yaw_rad", [-0.35, 0.0, 0.35])
def test_tracks_merge_by_their_distance_along_the_road_at_any_yaw(
    ahead_m: float, right_m: float, count: int, yaw_rad: float
) -> None:
    """Cars in neighbouring lanes, 4 m apart along the road, are 1.9 m apart across the axis of one turned by .35."""
    pose = np.array([0.0, 0.0, yaw_rad])
    tracks = two(ahead_m, right_m, pose)
    assert len(merged(tracks, pose, moving_obstacles())) == count


def test_no_point_belongs_to_two_tracks() -> None:
    drive, seen = traffic((vehicle(9.0, 3.3), 5.05), (vehicle(16.0, 1.3), 4.6)), Seen()
    seen.run(drive, range(60))
    pose = drive.pose(59)
    seen.moving.tracks = []
    for name, (start_m, right_m, speed_mps) in enumerate([(16.0, 1.3, 4.6), (9.0, 3.3, 5.05)], start=1):
        place_m = start_m + speed_mps - SPEED_MPS - CAMERA.forward_m, right_m - 1.0, right_m + 1.0
        seen.moving.tracks.append(believed(place_m, speed_mps, pose, name, sigma_mps=0.2))
    found = seen.run(drive, range(60, 120))
    far, nearer = sorted(seen.moving.tracks, key=lambda track: track.identity or 0)
    assert len(far.tracks)
    assert not np.isin(far.tracks, nearer.tracks).any()
    assert sorted(0.5 * (found[-1].left_m + found[-1].right_m)) == pytest.approx([1.3, 3.3], abs=0.35)


def test_point_tracks_older_than_a_fast_vehicle_is_in_sight_do_not_belong_to_it() -> None:
    """It drives 9 m/s, 3 m before the camera: .9 s ago it was beside us, and an older track is of what stands."""
    drive = Drive(body(12.0, 3.2, 1.8, 1.2, 12))
    for frame in range(60):
        flow = drive.flow(frame)
    course, old = Course(9.0, 0.0, 0.0), flow.age_frames > 52
    assert old.any()
    tracks = against(flow, CAMERA, course, np.full(len(flow), 3.0), RATE_HZ, WINDOW_PX, NoiseModel())
    track = believed((3.0, 2.3, 4.1), 9.0, flow.pose)
    chi2, _, change = track.fit(tracks, np.ones(len(flow)), SPEED_MPS, 3.0, np.ones(len(flow), np.bool_))
    assert np.isfinite(change)
    assert (chi2[old] > 1e3).all()


def test_a_predicted_track_hides_none_behind_it() -> None:
    """Beside us, beyond the picture, one is still tracked; the right half of another is visible where it would be."""
    drive, seen = traffic((vehicle(9.5, 3.2), 3.0)), Seen()
    seen.run(drive, range(60))
    beside = believed((3.6, 4.7, 6.7), 3.0, drive.pose(59), 99, sigma_mps=0.2)
    passed = next(track for track in seen.moving.tracks if track.identity is not None)
    seen.moving.tracks.append(beside)
    for frame in range(60, 84):
        seen.run(drive, range(frame, frame + 1))
        assert beside in seen.moving.tracks
        right_half = np.arange(10, 18)
        assert np.isin(passed.tracks, right_half).sum() >= 4


@pytest.mark.parametrize("yaw_rad", [-0.3, 0.0, 0.3])
def test_the_extent_does_not_depend_on_the_yaw_of_the_camera(yaw_rad: float) -> None:
    """Points all over a rear whose middle lies .5 m right of the estimate, on a road along the x axis."""
    pose, face_m = np.array([0.0, 0.0, yaw_rad]), 12.0
    forward, right = vehicle_from_world(np.array([face_m, 1.0]), pose)
    track = believed((float(forward) - CAMERA.forward_m, float(right) - 1.0, float(right) + 1.0), 0.0, pose)
    rear = vehicle_from_world(np.column_stack([np.full(20, face_m), 1.5 + np.linspace(-0.95, 0.95, 20)]), pose)
    bearing = rear[:, 1] / (rear[:, 0] - CAMERA.forward_m)
    for _ in range(20):
        track.predict(0.05, 0.0, 0.0)
        track.update_extent((bearing.min(), bearing.max()), bearing, np.full(20, 4.0), pose, 0.05)
    assert track.place(np.zeros(3)) == pytest.approx([face_m, 1.5], abs=0.2)
    assert track.is_observed


def test_a_vehicle_seen_from_its_side_does_not_update_its_extent() -> None:
    pose = np.array([0.0, 0.0, 1.2])
    track = believed((7.0, -1.0, 1.0), 3.0, pose)
    track.predict(0.0, 0.0, 0.0)
    track.predict(0.05, 0.0, 0.0)
    before = track.place(pose)
    track.update_extent((-0.15, 0.15), np.linspace(-0.2, 0.2, 9), np.full(9, 4.0), pose, 0.05)
    assert track.place(pose) == pytest.approx(before)
    assert not track.is_observed
