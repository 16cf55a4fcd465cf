"""The region of interest: standing points whose place on the road is known are in it or not."""

from dataclasses import replace

import numpy as np
import pytest

from vpf_sim.perception.paper.obstacle_region import Surroundings, inside
from vpf_sim.perception.paper.paper_settings import RegionConfig
from vpf_sim.planning.variant import load
from vpf_sim.types import Camera, Floats, RoadEdges

_PAPER = load("paper").obstacle_map.region
assert _PAPER is not None
REGION = _PAPER
CAMERA = Camera()
SPEED_MPS = 5.0
ROAD = RoadEdges(
    left_m=-8.75, right_m=5.25, heading_rad=0.0, curvature_per_m=0.0, sigma_m=0.02, confidence=1.0, lane_m=0.0,
    lane_width_m=3.5,
)  # fmt: skip


def seen(*places_m: tuple[float, float, float]) -> tuple[Floats, Floats]:
    """Pixels (N, 2) and times to contact (N,) of points at X ahead of the pose, Y to the right, Z above the road."""
    x, y, z = np.array(places_m).T
    depth = x - CAMERA.forward_m
    u = CAMERA.cx_px + CAMERA.fx_px * y / depth
    v = CAMERA.cy_px + CAMERA.fy_px * (CAMERA.height_m - z) / depth
    return np.stack([u, v], axis=1), depth / SPEED_MPS


def told(config: RegionConfig, *places_m: tuple[float, float, float], road: RoadEdges = ROAD) -> list[bool]:
    points, ttc_s = seen(*places_m)
    return [bool(one) for one in inside(points, CAMERA, Surroundings(road, SPEED_MPS, ttc_s), config)]


def test_the_corridor_holds_what_stands_on_the_road_within_the_horizon() -> None:
    config = replace(REGION, shape="horizon_corridor", margin_m=1.0, near_m=2.0, reach_m=27.5)
    assert told(config, (12.0, 0.0, 1.0), (12.0, 4.0, 1.0), (12.0, -7.5, 1.0)) == [True, True, True]
    assert told(config, (12.0, 4.5, 1.0), (12.0, -8.0, 1.0), (12.0, 7.0, 1.0)) == [False, False, False]
    assert told(config, (28.0, 0.0, 1.0), (28.6, 0.0, 1.0), (2.5, 0.0, 1.0)) == [True, False, False]


def test_what_is_flat_or_high_is_not_in_the_corridor() -> None:
    config = replace(REGION, shape="horizon_corridor")
    assert told(config, (12.0, 0.0, 0.05), (12.0, 0.0, 0.4), (12.0, 0.0, 2.4), (12.0, 0.0, 2.8)) == [
        False, True, True, False,
    ]  # fmt: skip


def test_the_road_corridor_has_no_end() -> None:
    assert told(replace(REGION, shape="road_corridor"), (60.0, 0.0, 1.0), (60.0, 8.0, 1.0)) == [True, False]


def test_the_corridor_bends_with_the_road_and_turns_with_its_heading() -> None:
    config = replace(REGION, shape="horizon_corridor", margin_m=0.0)
    bend = replace(ROAD, curvature_per_m=1.0 / 50.0)  # 20 m ahead the road has gone 4 m to the right
    assert told(config, (20.0, 7.0, 1.0), (20.0, -7.0, 1.0), road=bend) == [True, False]
    turned = replace(ROAD, heading_rad=-0.2)
    assert told(config, (20.0, -10.0, 1.0), (20.0, 3.0, 1.0), road=turned) == [True, False]


def test_points_without_a_time_to_contact_are_in_no_corridor() -> None:
    points, _ = seen((12.0, 0.0, 1.0))
    around = Surroundings(ROAD, SPEED_MPS, np.array([np.inf]))
    assert not inside(points, CAMERA, around, replace(REGION, shape="horizon_corridor")).any()


def test_the_full_frame_and_its_lower_part() -> None:
    places = ((12.0, 0.0, 1.0), (12.0, 0.0, 2.0), (12.0, 30.0, 0.0))
    assert told(replace(REGION, shape="full_frame"), *places) == [True, True, True]
    assert told(replace(REGION, shape="below_horizon"), *places) == [True, False, True]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"near_m": 0.0}, "near_m: expected > 0, got 0.0"),
        ({"height_m": (2.0, 1.0)}, r"height_m: expected the lower limit first, got \[2.0, 1.0\]"),
    ],
)
def test_a_region_without_inside_is_refused(keys: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(REGION, **keys)  # type: ignore[arg-type]
