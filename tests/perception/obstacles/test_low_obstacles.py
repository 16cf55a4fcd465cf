"""Low obstacles from simulated tracks: a pallet is found in time, what lies on the road or on its lines is not."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import section
from tracked_points import CAMERA, CORNER, RATE_HZ, SPEED_MPS, Drive, body, road_points, tracker

from vpf_sim.perception.obstacles.low_obstacles import off_lines
from vpf_sim.types import Floats, Obstacles, RoadEdges

BUMPER_M = 2.25  # ahead of the pose
FACE_M = 45.0


def pallet(right_m: float, height_m: float = 0.15) -> Floats:
    """Corners of boards on a pallet of 1.2 x 0.8 m, and of its feet."""
    top = [[FACE_M + x, right_m + y, height_m] for x in (0.0, 0.6, 1.2) for y in (-0.4, 0.4)]
    feet = [[FACE_M, right_m + y, 0.0] for y in (-0.4, 0.4)]
    return np.array(top + feet)


def approach(
    scene: Floats, noise_px: float = 0.1, curvature_per_m: float = 0.0, structure: Floats = CORNER
) -> list[Obstacles]:
    """What is reported of the scene on the way to 3 m before the pallet's face."""
    drive = Drive(np.concatenate([scene, road_points(200, curvature_per_m)]), noise_px, curvature_per_m, structure)
    frames = round((FACE_M - BUMPER_M - 3.0) / SPEED_MPS * RATE_HZ)
    return drive.run(tracker(), range(frames))


def first_gap_m(found: list[Obstacles]) -> float:
    """From bumper to face when the first obstacle is reported; -inf if none."""
    first = next((k for k, obstacles in enumerate(found) if len(obstacles)), None)
    return -np.inf if first is None else FACE_M - BUMPER_M - first * SPEED_MPS / RATE_HZ


@pytest.mark.parametrize("right_m", [-3.4, -0.3, 0.6, 3.2])
def test_a_pallet_is_detected_in_time_and_place(right_m: float) -> None:
    found = approach(pallet(right_m))
    assert first_gap_m(found) > 6.0
    assert len(found[-1]) == 1
    assert found[-1].forward_m[0] == pytest.approx(BUMPER_M + 3.0, abs=0.3)
    assert (found[-1].left_m[0], found[-1].right_m[0]) == pytest.approx((right_m - 0.4, right_m + 0.4), abs=0.15)


@pytest.mark.parametrize("height_m", [0.0, -0.15, -0.5])
def test_paint_and_reflections_are_no_pallet(height_m: float) -> None:
    assert first_gap_m(approach(pallet(0.3, height_m))) == -np.inf


@pytest.mark.parametrize(("texture", "reported"), [(13.0, False), (23.0, False), (33.0, True)])
def test_neither_asphalt_nor_ends_of_dashes_make_a_pallet(texture: float, reported: bool) -> None:
    """Asphalt has up to 13 grey levels^2 / px^2, 3 of 4 ends of dashes up to 23, most points of pallets over 30."""
    assert (first_gap_m(approach(pallet(0.3), structure=texture * np.eye(2))) > 4.0) == reported


@pytest.mark.parametrize(("share", "reported"), [(0.1, False), (1.0, True)])
def test_points_placed_on_a_line_are_ignored_wherever_their_ray_meets_the_road(share: float, reported: bool) -> None:
    """Rays of points 0.15 m above a line that is 5.25 m aside meet the road 0.63 m beside it. A pallet sticks out."""
    scene = pallet(0.0)
    scene[:, 1] = -5.25 + share * scene[:, 1]
    assert (first_gap_m(approach(scene)) > 5.0) == reported


@pytest.mark.parametrize(("right_m", "least_m", "most_m"), [(1.37, 6.0, 14.0), (0.8, 15.0, 21.0)])
def test_far_low_points_before_a_line_are_no_seeds(right_m: float, least_m: float, most_m: float) -> None:
    """The ray of a point 0.3 m high and 1.37 m aside meets the road on the line, 1.75 m aside."""
    scene = np.array([[FACE_M, right_m + y, 0.3 + z] for y in (-0.03, 0.03) for z in (-0.02, 0.02)])
    assert least_m < first_gap_m(approach(scene)) < most_m


@pytest.mark.parametrize(("width_m", "count", "feet_m"), [(1.8, 10, (-0.3, 0.3, 0.9)), (0.5, 12, (0.0, 0.3, 0.6))])
def test_low_points_of_a_taller_obstacle_belong_to_it(width_m: float, count: int, feet_m: tuple[float, ...]) -> None:
    """A car's wheels, a pedestrian's shoes."""
    feet = np.array([[FACE_M, y, 0.1] for y in feet_m])
    found = approach(np.concatenate([body(FACE_M, 0.3, width_m, 1.4, count), feet]))
    assert {len(obstacles) for obstacles in found[-100:]} == {1}


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_pallet_beside_a_pedestrian_is_detected_despite_a_point_between_them(side: float) -> None:
    """It sticks out of the pedestrian by less than the corner of a shadow may stick out of a car."""
    between = np.array([[FACE_M, side * -0.2, 0.35]])
    found = approach(np.concatenate([body(FACE_M, side * -0.9, 0.5, 1.5, 12), between, pallet(side * 0.1)]))[-1]
    assert len(found) == 2
    assert np.max(np.maximum(side * found.left_m, side * found.right_m)) > 0.45


def test_the_lines_are_where_the_edges_put_them() -> None:
    config = replace(section("static_obstacles.low_obstacles"), line_px=0.0)
    right = np.array([-8.8, -8.6, -5.25, -5.0, -1.6, 0.0, 1.6, 3.5, 4.9])
    places = np.column_stack([np.full(9, 10.0), right])
    road = RoadEdges(-8.75, 5.25, 0.0, 0.0, 0.05, 1.0, 0.0, 3.5)
    assert off_lines(CAMERA, places, road, config).tolist() == [
        False, False, False, True, False, True, False, True, False,
    ]  # fmt: skip


@pytest.mark.parametrize("heading_deg", [-50.0, -30.0, 30.0, 50.0])
def test_the_lines_of_a_turned_car_are_those_of_the_road(heading_deg: float) -> None:
    """Across its own axes the carriageway is as wide as five lanes or six."""
    config, heading = replace(section("static_obstacles.low_obstacles"), line_px=0.0), np.radians(heading_deg)
    across = np.array([-3.5, -2.0, 0.0, 1.75, 3.5])  # of the road, whose lines are at multiples of 3.5
    forward = np.full(5, 10.0)
    places = np.column_stack([forward, forward * np.tan(heading) + across / np.cos(heading)])
    road = RoadEdges(-7.0, 7.0, heading, 0.0, 0.05, 1.0, 1.75, 3.5)
    assert off_lines(CAMERA, places, road, config).tolist() == [False, True, False, True, False]
