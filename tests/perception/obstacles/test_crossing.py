"""Actors that cross, by points that are projected from known bodies while the car drives or turns."""

import numpy as np
import pytest
from driver_settings import static_obstacles

from vpf_sim.geometry import project, vehicle_from_world
from vpf_sim.perception.obstacles.crossing import Crossers, CrossingConfig, CrossingDetector
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Flow

CAMERA = Camera()
GAP_S, SPEED_MPS = 0.1, 5.5
CORNER = 400.0 * np.eye(2)
CONFIG = CrossingConfig(static_chi2=16.0, least_points=3, least_mps=0.6, fastest_mps=8.0, farthest_m=28.0)


def detector() -> CrossingDetector:
    config = static_obstacles()
    return CrossingDetector(CAMERA, CONFIG, config.window_px, config.noise)


def body(forward_m: float, right_m: float, width_m: float, low_m: float, high_m: float, count: int = 30) -> Floats:
    """(count, 3) points of an upright face, its lowest and highest among them."""
    random = stream(3, "body")
    points = random.uniform([-0.5 * width_m, low_m], [0.5 * width_m, high_m], (count, 2))
    points[0, 1], points[1, 1] = low_m, high_m
    return np.column_stack([np.full(count, forward_m), right_m + points[:, 0], points[:, 1]])


def road(count: int = 150) -> Floats:
    random = stream(4, "road")
    return np.column_stack([random.uniform(4.0, 30.0, count), random.uniform(-6.0, 6.0, count), np.zeros(count)])


def flow(points_m: Floats, velocity_mps: Floats, yaw_rate_radps: float = 0.0, noise_px: float = 0.05) -> Flow:
    """Of points (N, 3), places now with velocities (N, 2), for a car at the origin that comes along x."""
    turn = yaw_rate_radps * GAP_S
    before = np.array([-SPEED_MPS * GAP_S * np.cos(0.5 * turn), SPEED_MPS * GAP_S * np.sin(0.5 * turn), -turn])
    past = points_m.copy()
    past[:, :2] = vehicle_from_world(points_m[:, :2] - GAP_S * velocity_mps, before)
    random, count = stream(5, "noise"), len(points_m)
    now_px, past_px = (project(CAMERA, place) + random.normal(0.0, noise_px, (count, 2)) for place in (points_m, past))
    return Flow(
        now_px, now_px - past_px, np.full(count, GAP_S), np.tile(before, (count, 1)), np.zeros(3), np.arange(count),
        past_px, np.tile(before, (count, 1)), np.full(count, 2), np.tile(CORNER, (count, 1, 1)),
    )  # fmt: skip


def scene(actor: Floats, velocity_mps: tuple[float, float], yaw_rate_radps: float = 0.0) -> tuple[Crossers, Bools]:
    """What is found of an actor on a road; then (N,) which of the road's and which of the actor's points are near."""
    ground = road()
    moves = np.zeros((len(ground) + len(actor), 2))
    moves[len(ground) :] = velocity_mps
    return detector().find(flow(np.concatenate([ground, actor]), moves, yaw_rate_radps), SPEED_MPS)


@pytest.mark.parametrize("yaw_rate_radps", [0.0, 0.3, -0.3])
@pytest.mark.parametrize(
    ("forward_m", "right_m", "speed_mps"), [(8.0, 0.5, -1.5), (14.0, 2.0, -1.5), (18.0, -3.0, 3.0), (12.0, 0.0, 4.0)]
)
def test_an_actor_that_crosses_is_placed_with_its_speed(
    forward_m: float, right_m: float, speed_mps: float, yaw_rate_radps: float
) -> None:
    found, near = scene(body(forward_m, right_m, 0.5, 0.1, 1.7), (0.0, speed_mps), yaw_rate_radps)
    assert len(found) == 1
    depth_m = forward_m - CAMERA.forward_m
    assert found.depth_m[0] == pytest.approx(depth_m, rel=0.1)
    assert found.middle_m[0] == pytest.approx(right_m, abs=0.1 * abs(right_m) + 0.1)
    assert found.speed_mps[0] == pytest.approx(speed_mps, rel=0.15)
    assert near[-30:].all(), "its points are no static obstacle's"
    assert near.sum() < 60


def test_its_feet_may_be_hidden_where_its_motion_shows_its_depth() -> None:
    found, _ = scene(body(8.0, 1.0, 1.8, 0.5, 1.2), (0.0, 4.0))
    assert found.depth_m[0] == pytest.approx(8.0 - CAMERA.forward_m, rel=0.15)


@pytest.mark.parametrize("velocity_mps", [(0.0, 0.0), (3.0, 0.0), (-8.0, 0.0)])
def test_what_stands_or_drives_along_the_road_does_not_cross(velocity_mps: tuple[float, float]) -> None:
    found, near = scene(body(12.0, 0.3, 1.7, 0.1, 1.4), velocity_mps)
    assert not len(found)
    assert not near.any()


def test_an_empty_road_in_a_bend_shows_nobody() -> None:
    ground = road()
    found, _ = detector().find(flow(ground, np.zeros((len(ground), 2)), 0.4), SPEED_MPS)
    assert not len(found)


def test_what_lies_flat_or_hangs_high_does_not_cross() -> None:
    for low_m, high_m in ((0.0, 0.4), (2.5, 5.0)):
        found, _ = scene(body(12.0, 1.0, 0.6, low_m, high_m), (0.0, -2.0))
        assert not len(found)


def test_a_car_that_comes_in_a_bend_is_oncoming_traffic() -> None:
    found, _ = scene(body(18.0, -1.0, 1.8, 0.15, 1.4), (-7.0, 2.0))
    assert found.depth_m[0] == pytest.approx(18.0 - CAMERA.forward_m, rel=0.1)
    assert found.along_mps[0] == pytest.approx(-7.0, abs=2.0)
    assert found.speed_mps[0] == pytest.approx(2.0, abs=0.6)
