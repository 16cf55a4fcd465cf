"""Detections of what perception reports: support by points above the road, and lengths."""

from types import SimpleNamespace
from typing import Any

import driver_settings
import numpy as np
import pytest

from vpf_sim.scene.camera import road_of
from vpf_sim.scene.measurements import of_obstacles, support
from vpf_sim.types import Floats, Obstacles, RoadEdges

CAMERA_M, SPEED_MPS = 0.8, 5.0
CONFIG = driver_settings.scene().existence


def obstacle(forward_m: float) -> Obstacles:
    one = np.ones(1)
    return Obstacles(forward_m * one, -0.4 * one, 0.4 * one, 0.2 * one, one, np.array([0]))


def points(forward_m: Floats, height_m: float) -> Any:
    """Well measured points in the middle of the road, none of which the flat road explains if they are high."""
    count = len(forward_m)
    chi2 = np.ones(count)
    return SimpleNamespace(
        depth_m=forward_m - CAMERA_M, right_m=np.zeros(count), height_m=np.full(count, height_m),
        height_sigma_m=np.full(count, 0.02), chi2=chi2, chi2_ground=chi2 + 1e3 * height_m**2,
    )  # fmt: skip


def test_points_above_the_road_speak_for_an_obstacle_and_paint_against_it() -> None:
    there = np.full(4, 6.2)
    assert support(obstacle(6.0), points(there, 0.3), CAMERA_M, SPEED_MPS, CONFIG)[0] == CONFIG.points_most
    assert support(obstacle(6.0), points(there, 0.0), CAMERA_M, SPEED_MPS, CONFIG)[0] < -0.5
    assert support(obstacle(6.0), points(there + 4.0, 0.3), CAMERA_M, SPEED_MPS, CONFIG)[0] < -0.5


def test_what_has_left_the_view_beside_the_car_is_no_evidence_of_paint() -> None:
    """A face from 2.6 to 8 m aside, 5 m ahead: a quarter of it is within the view, and no points are found."""
    aside, one = obstacle(5.0), np.ones(1)
    beside = Obstacles(aside.forward_m, 2.6 * one, 8.0 * one, aside.sigma_m, one, aside.identity)
    ahead = support(aside, points(np.full(4, 5.0), 0.0), CAMERA_M, SPEED_MPS, CONFIG)[0]
    assert 0.35 * ahead < support(beside, points(np.full(4, 5.0), 0.0), CAMERA_M, SPEED_MPS, CONFIG)[0] < 0.0


def test_a_face_without_width_has_its_points_and_one_out_of_view_has_none() -> None:
    one, thin = np.ones(1), obstacle(6.0)
    line = Obstacles(thin.forward_m, 0.0 * one, 0.0 * one, thin.sigma_m, one, thin.identity)
    assert support(line, points(np.full(4, 6.2), 0.3), CAMERA_M, SPEED_MPS, CONFIG)[0] == CONFIG.points_most
    beside = Obstacles(thin.forward_m, 5.0 * one, 7.0 * one, thin.sigma_m, one, thin.identity)
    assert np.isnan(support(beside, points(np.full(4, 6.0), 0.0), CAMERA_M, SPEED_MPS, CONFIG)[0])


@pytest.mark.parametrize(("forward_m", "speed_mps"), [(2.0, SPEED_MPS), (12.0, SPEED_MPS), (6.0, 0.0)])
def test_a_place_without_measured_heights_tells_nothing(forward_m: float, speed_mps: float) -> None:
    assert np.isnan(support(obstacle(forward_m), points(np.full(4, forward_m), 0.0), CAMERA_M, speed_mps, CONFIG)[0])


def lengths(*faces: tuple[float, float, float]) -> list[float]:
    """m, of standing faces (ahead m, left side m, right side m)."""
    ahead, left, right = np.array(faces, float).T
    same = np.ones(len(faces))
    road = road_of(RoadEdges(-5.25, 5.25, 0.0, 0.0, 0.1, 1.0, 0.0, 3.5, 1.0), np.zeros(3), 0.0)
    seen = Obstacles(ahead, left, right, 0.2 * same, same, np.arange(len(faces)))
    found = of_obstacles(seen, np.nan * same, 0.0 * same, np.zeros(3), road, 0.0, CONFIG)
    return [float(one) for one in found.length_m]


def test_what_a_truck_leaves_of_a_van_behind_it_is_as_long_as_a_vehicle() -> None:
    """Of the van, whose face is 1.4 m farther, a strip of 0.4 m shows beside the truck."""
    strip, truck = (14.4, 0.8, 1.2), (13.0, -3.7, 0.6)
    (alone,) = lengths(strip)
    assert alone < 2.0
    assert min(lengths(strip, truck)) > 5.0


@pytest.mark.parametrize("cone", [(14.4, 2.2, 2.6), (19.0, 0.8, 1.2)])
def test_a_cone_farther_aside_or_behind_stays_short(cone: tuple[float, float, float]) -> None:
    assert lengths(cone, (13.0, -3.7, 0.6))[0] == lengths(cone)[0]
