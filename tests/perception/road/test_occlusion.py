"""What known bodies cover and hide of the road, against lines of sight followed point by point."""

import cv2
import numpy as np
import pytest
from made_obstacles import obstacles

from vpf_sim.geometry import rotation
from vpf_sim.perception.object_sizes import CAR_LENGTH_M
from vpf_sim.perception.road.occlusion import BEFORE_M, BESIDE_M, footprints, shadow
from vpf_sim.types import Bools, Floats, RoadEdges

LENS_M = np.array([0.8, 0.0])


def road(heading_rad: float = 0.0, curvature_per_m: float = 0.0) -> RoadEdges:
    return RoadEdges(-9.0, 5.0, heading_rad, curvature_per_m, 0.05, 1.0, 0.0, 3.5)


def inside(points_m: Floats, corners_m: Floats) -> Bools:
    """(N,) of points, whether within a rectangle (4, 2)."""
    first, second = corners_m[1] - corners_m[0], corners_m[3] - corners_m[0]
    parts = [(points_m - corners_m[0]) @ side / (side @ side) for side in (first, second)]
    return np.asarray(np.all([(part >= 0.0) & (part <= 1.0) for part in parts], axis=0), np.bool_)


@pytest.mark.parametrize("face_m", [9.0, 1.2, -4.0])
@pytest.mark.parametrize("heading_rad", [0.0, 0.2, -0.3])
def test_what_a_line_of_sight_meets_a_body_on_is_hidden_and_nothing_else(face_m: float, heading_rad: float) -> None:
    """Also where the body's face lies behind the camera and its flank beside it."""
    (corners,) = footprints(obstacles((face_m, -4.0, -1.6)), road(heading_rad))
    outline = shadow(corners, LENS_M).astype(np.float32)
    grid = np.stack(np.meshgrid(np.arange(1.0, 16.0, 0.5), np.arange(-8.0, 4.0, 0.25)), axis=-1).reshape(-1, 2)
    share = np.linspace(0.0, 1.0, 400)[:, None]
    met = np.array([inside(LENS_M + share * (point - LENS_M), corners).any() for point in grid])
    distance = np.array([cv2.pointPolygonTest(outline, point.tolist(), True) for point in grid])
    assert 20 < met.sum() < len(grid) - 20
    assert np.all((distance > 0.0)[np.abs(distance) > 0.1] == met[np.abs(distance) > 0.1])


@pytest.mark.parametrize(("width_m", "length_m"), [(0.4, 1.0), (2.0, 5.5), (2.2, 5.5), (2.5, 9.0)])
def test_what_is_as_wide_as_a_car_or_a_truck_may_be_as_long(width_m: float, length_m: float) -> None:
    (corners,) = footprints(obstacles((10.0, 1.0, 1.0 + width_m)), road())
    assert corners.max(axis=0) == pytest.approx([10.0 + length_m, 1.0 + width_m + BESIDE_M])
    assert corners.min(axis=0) == pytest.approx([10.0 - BEFORE_M, 1.0 - BESIDE_M])


def test_it_stands_along_the_road_where_that_bends() -> None:
    (straight,), (bent,) = (footprints(obstacles((10.0, -1.25, 1.25)), on) for on in (road(), road(0.1, 0.01)))
    middle = np.array([10.0, 0.0])
    assert bent == pytest.approx(middle + (straight - middle) @ rotation(0.2).T)


def test_a_body_told_where_the_camera_is_hides_no_more_than_it_covers() -> None:
    (corners,) = footprints(obstacles((-4.0, -1.2, 1.2)), road())
    assert shadow(corners, LENS_M) == pytest.approx(corners)


def test_what_moves_covers_also_where_it_was_in_the_older_picture() -> None:
    (corners,) = footprints(obstacles((10.0, -1.0, 1.0), speed_mps=[3.0]), road(), since_s=0.8)
    assert corners[:, 0].min() == pytest.approx(10.0 - 3.0 * 0.8 - BEFORE_M)
    assert corners[:, 0].max() == pytest.approx(10.0 + CAR_LENGTH_M)
