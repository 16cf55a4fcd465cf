"""Detections of what perception reports: support by points above the road, and lengths."""

from types import SimpleNamespace
from typing import Any

import driver_settings
import numpy as np
import pytest
from made_obstacles import obstacles

from vpf_sim.scene.camera import road_of
from vpf_sim.scene.measurements import of_obstacles, support
from vpf_sim.types import RoadEdges

CAMERA_M, SPEED_MPS = 0.8, 5.0
CONFIG = driver_settings.scene().existence


def supported(
    forward_m: float,
    points_m: float,
    height_m: float,
    sides_m: tuple[float, float] = (-0.4, 0.4),
    speed_mps: float = SPEED_MPS,
) -> float:
    """The support of an obstacle by four well measured points; the flat road does not explain them if they are high."""
    same = np.ones(4)
    seen: Any = SimpleNamespace(
        depth_m=(points_m - CAMERA_M) * same, right_m=0.0 * same, height_m=height_m * same,
        height_sigma_m=0.02 * same, chi2=same, chi2_ground=(1.0 + 1e3 * height_m**2) * same,
    )  # fmt: skip
    return float(support(obstacles((forward_m, *sides_m)), seen, CAMERA_M, speed_mps, CONFIG)[0])


def test_points_above_the_road_speak_for_an_obstacle_and_paint_against_it() -> None:
    assert supported(6.0, 6.2, 0.3) == CONFIG.points_most
    assert supported(6.0, 6.2, 0.0) < -0.5
    assert supported(6.0, 10.2, 0.3) < -0.5


def test_what_has_left_the_view_beside_the_car_is_no_evidence_of_paint() -> None:
    """A face from 2.6 to 8 m aside, 5 m ahead: a quarter of it is within the view, and no points are found."""
    assert 0.35 * supported(5.0, 5.0, 0.0) < supported(5.0, 5.0, 0.0, (2.6, 8.0)) < 0.0


def test_a_face_without_width_has_its_points_and_one_out_of_view_has_none() -> None:
    assert supported(6.0, 6.2, 0.3, (0.0, 0.0)) == CONFIG.points_most
    assert np.isnan(supported(6.0, 6.0, 0.0, (5.0, 7.0)))


@pytest.mark.parametrize(("forward_m", "speed_mps"), [(2.0, SPEED_MPS), (12.0, SPEED_MPS), (6.0, 0.0)])
def test_a_place_without_measured_heights_tells_nothing(forward_m: float, speed_mps: float) -> None:
    assert np.isnan(supported(forward_m, forward_m, 0.0, speed_mps=speed_mps))


def lengths(*faces: tuple[float, float, float]) -> list[float]:
    """m, of standing faces (ahead m, left side m, right side m)."""
    same = np.ones(len(faces))
    road = road_of(RoadEdges(-5.25, 5.25, 0.0, 0.0, 0.1, 1.0, 0.0, 3.5, 1.0), np.zeros(3), 0.0)
    found = of_obstacles(obstacles(*faces), np.nan * same, 0.0 * same, np.zeros(3), road, 0.0, CONFIG)
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
