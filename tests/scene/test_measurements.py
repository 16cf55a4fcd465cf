"""Detections of what perception reports: support by points above the road."""

from types import SimpleNamespace
from typing import Any

import driver_settings
import numpy as np
import pytest

from vpf_sim.scene.measurements import support
from vpf_sim.types import Floats, Obstacles

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


@pytest.mark.parametrize(("forward_m", "speed_mps"), [(2.0, SPEED_MPS), (12.0, SPEED_MPS), (6.0, 0.0)])
def test_a_place_without_measured_heights_tells_nothing(forward_m: float, speed_mps: float) -> None:
    assert np.isnan(support(obstacle(forward_m), points(np.full(4, forward_m), 0.0), CAMERA_M, speed_mps, CONFIG)[0])
