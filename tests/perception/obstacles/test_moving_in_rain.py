"""Bodies that move on a road that mirrors: simulated tracks of cars, of trees beside the road, and of their images."""

import numpy as np
import pytest
from test_moving_tracker import Contrasted, Seen, vehicle
from tracked_points import CAMERA, RATE_HZ, SPEED_MPS, tracker

from vpf_sim.perception.obstacles.moving.detection import Apparent, MoverConfig, appear, outlines
from vpf_sim.perception.obstacles.moving.evidence import EvidenceConfig
from vpf_sim.perception.obstacles.moving.track import Mover, Sight
from vpf_sim.perception.obstacles.moving.tracker import MoverTracker
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
def test_a_car_ahead_is_found_at_its_foot_and_not_at_that_of_its_image(dark: float) -> None:
    drive = wet((vehicle(27.0, 0.3), 3.0, float(np.exp(dark))))
    found = Seen().run(drive, range(round(4.5 * RATE_HZ)))
    first = next(k for k, bodies in enumerate(found) if (bodies.identity < 0).any())
    assert 27.0 + (3.0 - SPEED_MPS) * first / RATE_HZ > 18.0
    last = found[-1]
    assert last.identity.tolist() == [-1]
    assert last.forward_m == pytest.approx([27.0 + (3.0 - SPEED_MPS) * (len(found) - 1) / RATE_HZ], abs=1.0)
    assert last.speed_mps == pytest.approx([3.0], abs=0.4)


@pytest.mark.parametrize("image", [IMAGE, -0.8])
def test_the_images_of_trees_are_no_bodies(image: float) -> None:
    """Nor where they have more contrast than a body's own image: they would stand beside the road."""
    found = Seen().run(wet(image=image), range(round(4.0 * RATE_HZ)))
    assert not any((bodies.identity < 0).any() for bodies in found)


def test_a_truck_that_stands_on_the_road_has_no_body_for_an_image() -> None:
    """What would be mirrored stands on the road here; its image is fainter than it."""
    truck = vehicle(50.0, 0.3, 40, 2.5) * [1.0, 1.0, 2.0]
    found = Seen().run(wet((truck, 0.0, 1.0)), range(round(7.0 * RATE_HZ)))
    assert not any((bodies.identity < 0).any() for bodies in found)
    assert found[-1].forward_m == pytest.approx([50.0 - SPEED_MPS * (len(found) - 1) / RATE_HZ], abs=0.5)


def test_a_suspect_goes_to_its_foot_wherever_that_is_and_a_body_rather_towards_us() -> None:
    """From 14 m, within half a second: the share of the way to where its lowest points stand."""
    pose = np.zeros(3)

    def moved(foot_m: float, identity: int | None) -> float:
        mover = Mover(Sight(14.0, 3.0, 0.5, -1.0, 1.0), CAMERA, pose, 0.0, MoverConfig().filter)
        mover.identity = identity
        for _ in range(10):
            mover.stand(foot_m, SPEED_MPS, pose, 0.05)
        return (mover.depth_m(pose) - 14.0) / (foot_m - 14.0)

    assert moved(17.0, None) > 0.4
    assert moved(17.0, 1) < 0.5 * moved(17.0, None)
    assert moved(11.0, None) == moved(11.0, 1) > 0.4


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("depth_m", [2.0, 0.0, -2.5])
def test_the_flank_of_a_body_that_is_passed_is_no_landmark(depth_m: float, side: float) -> None:
    """Its face is beside the camera, out of the picture; what stands on the other side is."""
    along = np.repeat(np.linspace(1.2, 4.0, 8), 3)
    flank = np.column_stack([CAMERA.forward_m + along, np.full(24, side * 2.3), np.tile([0.3, 0.7, 1.1], 8)])
    drive, seen = wet((flank, 0.0, 1.0), (flank * [1.0, -1.0, 1.0], 0.0, 1.0)), Seen()
    flow = last_of(drive, 10)
    seen.movers.movers.append(believed(depth_m, side * 3.3, flow.pose))
    moving = seen.movers.update(flow, seen.landmarks.triangulate(flow), drive.road, SPEED_MPS, 9 / RATE_HZ)
    place = drive.scene[flow.identity] - [*flow.pose[:2], 0.0]
    beside = (flow.identity < 48) & (place[:, 0] - CAMERA.forward_m > 1.0)
    mine = beside & (place[:, 1] * side > 0.0) & (place[:, 0] - CAMERA.forward_m < depth_m + 4.4)
    assert depth_m < -2.0 or np.count_nonzero(mine) >= 3
    assert moving[mine].all()
    assert np.count_nonzero(beside & (place[:, 1] * side < 0.0)) >= 3
    assert not moving[place[:, 1] * side < 0.0].any()


@pytest.mark.parametrize("depth_m", [0.4, 0.0, -2.0])
def test_a_body_that_would_be_where_we_are_hides_nothing(depth_m: float) -> None:
    drive, seen = wet(), Seen()
    flow = last_of(drive, 10)
    seen.movers.movers.append(believed(depth_m, 0.3, flow.pose))
    assert not seen.movers.update(flow, seen.landmarks.triangulate(flow), drive.road, SPEED_MPS, 9 / RATE_HZ).any()


def believed(depth_m: float, right_m: float, pose: Floats) -> Mover:
    """A body that is sure to drive there at 3 m/s."""
    mover = Mover(Sight(depth_m, 3.0, 0.1, right_m - 1.0, right_m + 1.0), CAMERA, pose, 6.0, MoverConfig().filter)
    mover.identity = 1
    return mover


@pytest.mark.parametrize(
    ("speed_mps", "right_m", "is_on_road"),
    [(3.0, 0.3, True), (3.0, 2.8, False), (3.0, -4.5, False), (4.6, 0.3, False), (6.0, 0.3, False)],
)
def test_what_would_be_mirrored_stands_on_the_road_as_far_as_that_is_known(
    speed_mps: float, right_m: float, is_on_road: bool
) -> None:
    """A body at 18 m is the image of what stands 18 / (1 - v_b / v) m off: 39 m at 3 m/s, 105 m at 4.6, none faster."""
    movers, evidence = MoverTracker(CAMERA, MoverConfig(), RATE_HZ), MoverConfig().evidence
    sight = Sight(18.0, speed_mps, 0.5, right_m - 1.0, right_m + 1.0)
    mover = Mover(sight, CAMERA, np.zeros(3), 0.0, MoverConfig().filter)
    for image in (-1.2, -2.5):  # above and below what asphalt is
        expected = max(image, evidence.faint(0.0, 18.0)) if is_on_road else evidence.faint(1.0, 18.0)
        assert movers._faint(mover, image, SPEED_MPS, np.zeros(3), wet().road) == pytest.approx(expected)


def test_nearer_than_the_road_mirrors_a_body_is_not_compared_with_its_image() -> None:
    movers, evidence = MoverTracker(CAMERA, MoverConfig(), RATE_HZ), MoverConfig().evidence
    near = Mover(Sight(5.0, 3.0, 0.5, -1.0, 1.0), CAMERA, np.zeros(3), 0.0, MoverConfig().filter)
    assert movers._faint(near, -2.5, SPEED_MPS, np.zeros(3), wet().road) == pytest.approx(evidence.faint(1.0, 5.0))


def apparent(drive: Contrasted, frames: int) -> Apparent:
    flow = last_of(drive, frames)
    return appear(flow, tracker().triangulate(flow), CAMERA, RATE_HZ, MoverConfig())


def test_a_body_is_compared_with_its_image_by_what_of_it_is_half_a_metre_up_and_no_higher_than_a_car() -> None:
    """Its upper part has a contrast of -0.9, what is low -3, and trees above it 0."""
    heights = np.repeat([0.2, 0.8, 2.5], 6)
    place = np.column_stack([np.full(18, 15.0), np.tile(np.linspace(-0.8, 0.8, 6), 3), heights])
    parts = [
        (place[heights == high], 0.0, float(np.exp(share))) for high, share in ((0.2, -3.0), (0.8, -0.9), (2.5, 0.0))
    ]
    seen, movers = apparent(wet(*parts), 30), MoverTracker(CAMERA, MoverConfig(), RATE_HZ)
    depth = 15.0 - 29 * SPEED_MPS / RATE_HZ - CAMERA.forward_m
    mine = np.arange(18)
    assert movers._image(seen, mine, depth) == pytest.approx(-2.0, abs=0.05)
    assert movers._image(seen, mine, 0.99 * MoverConfig().steep_m) == -np.inf


def test_who_is_brightest_is_suspected_first() -> None:
    """Two cars, the fainter with more points."""
    bright, faint = vehicle(16.0, -2.5, 10), vehicle(16.0, 2.5, 24)
    seen = apparent(wet((faint, 3.0, float(np.exp(-1.4))), (bright, 3.0, 1.0)), 40)
    feet = np.flatnonzero(seen.moves)
    first = outlines(seen, feet, 1, CAMERA, MoverConfig())[0]
    assert (seen.bearing[first] < 0.0).all()


@pytest.mark.parametrize("key", ["bright", "least_bright"])
def test_weights_that_make_no_order_are_refused(key: str) -> None:
    with pytest.raises(ValueError, match=key):
        MoverConfig(**{key: {"bright": (-0.8, -1.5), "least_bright": 0.0}[key]})  # type: ignore[arg-type]


@pytest.mark.parametrize(("key", "value"), [("dry_image", -1.0), ("image_ramp", 0.0)])
def test_contrasts_of_images_that_make_no_order_are_refused(key: str, value: float) -> None:
    with pytest.raises(ValueError, match=key):
        EvidenceConfig(**{key: value})
