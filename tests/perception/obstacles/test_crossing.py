"""Actors that cross, by points that are projected from known bodies while the car drives or turns."""

import numpy as np
import pytest
from made_flow import CAMERA, SPEED_MPS, body, flow, motions, road

from vpf_sim.perception.obstacles.crossing import Crossers, CrossingConfig, CrossingDetector
from vpf_sim.types import Bools, Floats, Flow

CONFIG = CrossingConfig(static_chi2=16.0, least_points=3, least_mps=0.6, fastest_mps=8.0, farthest_m=28.0)


def find(flow: Flow) -> tuple[Crossers, Bools]:
    return CrossingDetector(CAMERA, CONFIG).find(flow, motions(flow), SPEED_MPS)


def scene(actor: Floats, velocity_mps: tuple[float, float], yaw_rate_radps: float = 0.0) -> tuple[Crossers, Bools]:
    """What is found of an actor on a road; then (N,) which of the road's and which of the actor's points are near."""
    ground = road()
    moves = np.zeros((len(ground) + len(actor), 2))
    moves[len(ground) :] = velocity_mps
    return find(flow(np.concatenate([ground, actor]), moves, yaw_rate_radps))


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


@pytest.mark.parametrize(
    ("low_m", "high_m", "velocity_mps"),
    [
        pytest.param(0.1, 1.4, (0.0, 0.0), id="stands"),
        pytest.param(0.1, 1.4, (3.0, 0.0), id="drives ahead"),
        pytest.param(0.1, 1.4, (-8.0, 0.0), id="comes towards the car"),
        pytest.param(0.0, 0.4, (0.0, -2.0), id="lies flat"),
        pytest.param(2.5, 5.0, (0.0, -2.0), id="hangs high"),
    ],
)
def test_no_actor_crosses(low_m: float, high_m: float, velocity_mps: tuple[float, float]) -> None:
    found, near = scene(body(12.0, 0.6, 1.2, low_m, high_m), velocity_mps)
    assert not len(found)
    assert not near.any()


def test_an_empty_road_in_a_bend_shows_nobody() -> None:
    ground = road()
    found, _ = find(flow(ground, np.zeros((len(ground), 2)), 0.4))
    assert not len(found)


def test_a_car_that_comes_in_a_bend_is_oncoming_traffic() -> None:
    found, _ = scene(body(18.0, -1.0, 1.8, 0.15, 1.4), (-7.0, 2.0))
    assert found.depth_m[0] == pytest.approx(18.0 - CAMERA.forward_m, rel=0.1)
    assert found.along_mps[0] == pytest.approx(-7.0, abs=2.0)
    assert found.speed_mps[0] == pytest.approx(2.0, abs=0.6)
