"""Moving vehicles on a mirroring road: simulated point tracks of cars, of trees, and of their images."""

import numpy as np
import pytest
from driver_settings import moving_obstacles
from test_moving_tracker import Contrasted, Seen, believed, vehicle
from tracked_points import CAMERA, RATE_HZ, SPEED_MPS, tracker

from vpf_sim.perception.obstacles.moving.detection import MeasuredPoints, measure
from vpf_sim.perception.obstacles.moving.mirror import MirrorImages, faint_contrast
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Flow

IMAGE = -1.7  # logarithm of the squared contrast of an image as a share of what is mirrored


def wet(*cars: tuple[Floats, float, float], image: float = IMAGE) -> Contrasted:
    """Cars, with a speed and a squared contrast each, and trees on both sides, of contrast 1, all with their images."""
    rng = stream(41, "trees")
    side = np.repeat([-1.0, 1.0], 150)
    trees = np.column_stack(
        [rng.uniform(12.0, 90.0, 300), side * rng.uniform(9.0, 14.0, 300), rng.uniform(0.5, 6.0, 300)]
    )
    parts = [*cars, (trees, 0.0, 1.0)]
    scene = np.concatenate([points for points, _, _ in parts])
    speed = np.concatenate([np.full(len(points), speed) for points, speed, _ in parts])
    contrast = np.concatenate([np.full(len(points), contrast) for points, _, contrast in parts])
    return Contrasted(
        np.concatenate([scene, scene * [1.0, 1.0, -1.0]]),
        np.tile(speed, 2),
        np.concatenate([contrast, contrast * np.exp(image)]),
    )


def last_of(drive: Contrasted, frames: int) -> Flow:
    return [drive.flow(frame) for frame in range(frames)][-1]


@pytest.mark.parametrize("dark", [0.0, -0.5, -0.9])
def test_a_car_ahead_is_detected_at_its_foot_and_not_at_its_images(dark: float) -> None:
    drive = wet((vehicle(27.0, 0.3), 3.0, float(np.exp(dark))))
    found = Seen().run(drive, range(round(4.5 * RATE_HZ)))
    first = next(k for k, obstacles in enumerate(found) if (obstacles.identity < 0).any())
    assert 27.0 + (3.0 - SPEED_MPS) * first / RATE_HZ > 18.0
    last = found[-1]
    assert last.identity.tolist() == [-1]
    assert last.forward_m == pytest.approx([27.0 + (3.0 - SPEED_MPS) * (len(found) - 1) / RATE_HZ], abs=1.0)
    assert last.speed_mps == pytest.approx([3.0], abs=0.4)


@pytest.mark.parametrize("image", [IMAGE, -0.8])
def test_mirror_images_of_trees_are_no_vehicles(image: float) -> None:
    """Even with more contrast than a vehicle's own image: the trees stand beside the road."""
    found = Seen().run(wet(image=image), range(round(4.0 * RATE_HZ)))
    assert not any((obstacles.identity < 0).any() for obstacles in found)


def test_the_mirror_image_of_a_standing_truck_is_no_vehicle() -> None:
    """What would be mirrored stands on the road here; its image is fainter than it."""
    truck = vehicle(50.0, 0.3, 40, 2.5) * [1.0, 1.0, 2.0]
    found = Seen().run(wet((truck, 0.0, 1.0)), range(round(7.0 * RATE_HZ)))
    assert not any((obstacles.identity < 0).any() for obstacles in found)
    assert found[-1].forward_m == pytest.approx([50.0 - SPEED_MPS * (len(found) - 1) / RATE_HZ], abs=0.5)


def test_a_confirmed_track_moves_less_to_a_farther_foot_than_a_tentative_one() -> None:
    """From 14 m, within half a second: the share of the way to where its lowest points stand."""
    pose = np.zeros(3)

    def moved(foot_m: float, identity: int | None) -> float:
        track = believed((14.0, -1.0, 1.0), 3.0, pose, identity)
        for _ in range(10):
            track.update_range(foot_m, SPEED_MPS, pose, 0.05)
        return (track.depth_m(pose) - 14.0) / (foot_m - 14.0)

    assert moved(17.0, None) > 0.4
    assert moved(17.0, 1) < 0.5 * moved(17.0, None)
    assert moved(11.0, None) == moved(11.0, 1) > 0.4


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("depth_m", [2.0, 0.0, -2.5])
def test_the_flank_of_a_passed_vehicle_is_masked(depth_m: float, side: float) -> None:
    """Its face is beside the camera, out of the picture; what stands on the other side is."""
    along = np.repeat(np.linspace(1.2, 4.0, 8), 3)
    flank = np.column_stack([CAMERA.forward_m + along, np.full(24, side * 2.3), np.tile([0.3, 0.7, 1.1], 8)])
    drive, seen = wet((flank, 0.0, 1.0), (flank * [1.0, -1.0, 1.0], 0.0, 1.0)), Seen()
    flow = last_of(drive, 10)
    place_m = depth_m, side * 3.3 - 1.0, side * 3.3 + 1.0
    seen.moving.tracks.append(believed(place_m, 3.0, flow.pose, 1, 6.0, 0.1))
    moving = seen.moving.update(flow, seen.static.triangulate(flow), drive.road, SPEED_MPS, 9 / RATE_HZ)
    place = drive.scene[flow.identity] - [*flow.pose[:2], 0.0]
    beside = (flow.identity < 48) & (place[:, 0] - CAMERA.forward_m > 1.0)
    mine = beside & (place[:, 1] * side > 0.0) & (place[:, 0] - CAMERA.forward_m < depth_m + 4.4)
    assert depth_m < -2.0 or np.count_nonzero(mine) >= 3
    assert moving[mine].all()
    assert np.count_nonzero(beside & (place[:, 1] * side < 0.0)) >= 3
    assert not moving[place[:, 1] * side < 0.0].any()


@pytest.mark.parametrize("depth_m", [0.4, 0.0, -2.0])
def test_a_track_at_our_own_place_masks_nothing(depth_m: float) -> None:
    drive, seen = wet(), Seen()
    flow = last_of(drive, 10)
    seen.moving.tracks.append(believed((depth_m, -0.7, 1.3), 3.0, flow.pose, 1, 6.0, 0.1))
    assert not seen.moving.update(flow, seen.static.triangulate(flow), drive.road, SPEED_MPS, 9 / RATE_HZ).any()


@pytest.mark.parametrize(
    ("depth_m", "speed_mps", "right_m", "counts_less"),
    [
        (18.0, 3.0, 0.3, True),
        *((18.0, *others, False) for others in ((3.0, 2.8), (3.0, -4.5), (4.6, 0.3), (6.0, 0.3))),
        pytest.param(5.0, 3.0, 0.0, False, id="a near track is not compared with its image"),
    ],
)
def test_contrast_counts_less_where_the_mirrored_object_would_stand_on_the_road(
    depth_m: float, speed_mps: float, right_m: float, counts_less: bool
) -> None:
    """A body at 18 m is the image of what stands 18 / (1 - v_b / v) m off: 39 m at 3 m/s, 105 m at 4.6, none faster."""
    images, contrast = MirrorImages(CAMERA, moving_obstacles(), 0.05), moving_obstacles().evidence.contrast
    track = believed((depth_m, right_m - 1.0, right_m + 1.0), speed_mps, np.zeros(3))
    for image in (-1.2, -2.5):  # above and below what asphalt is
        wet_limit, dry_limit = (faint_contrast(mirror, depth_m, contrast) for mirror in (1.0, 0.0))
        expected = max(image, dry_limit) if counts_less else wet_limit
        assert images.faint(track, image, SPEED_MPS, np.zeros(3), wet().road) == pytest.approx(expected)


def apparent(drive: Contrasted, frames: int) -> MeasuredPoints:
    flow = last_of(drive, frames)
    return measure(flow, tracker().triangulate(flow), CAMERA, RATE_HZ, moving_obstacles())


def test_a_vehicle_is_compared_with_its_image_by_its_upper_part() -> None:
    """Its upper part has a contrast of -0.9, what is low -3, and trees above it 0."""
    heights = np.repeat([0.2, 0.8, 2.5], 6)
    place = np.column_stack([np.full(18, 15.0), np.tile(np.linspace(-0.8, 0.8, 6), 3), heights])
    parts = [
        (place[heights == high], 0.0, float(np.exp(share))) for high, share in ((0.2, -3.0), (0.8, -0.9), (2.5, 0.0))
    ]
    seen, images = apparent(wet(*parts), 30), MirrorImages(CAMERA, moving_obstacles(), 0.05)
    depth = 15.0 - 29 * SPEED_MPS / RATE_HZ - CAMERA.forward_m
    mine = np.arange(18)
    assert images.own_image(seen, mine, depth) == pytest.approx(-2.0, abs=0.05)
    assert images.own_image(seen, mine, 0.99 * moving_obstacles().steep_m) == -np.inf
