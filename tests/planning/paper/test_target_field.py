"""The target's force: -grad of 1/2 alpha r^2, and what the printed angle makes of it."""

from dataclasses import replace
from math import atan2, degrees, hypot, radians

import numpy as np
import pytest
from paper_planner import PAPER

from vpf_sim.geometry import rotation
from vpf_sim.planning.paper.lane import Lane
from vpf_sim.planning.paper.target_field import force

STRAIGHT = Lane(0.0, 5.25, -8.75, 0.0, 0.0)
REPAIRED = replace(PAPER.target_field, alpha=1.3, reach_m=None)
PRINTED = replace(REPAIRED, direction="printed")


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("goal", [(100.0, 5.0), (-20.0, 3.0), (0.0, -7.0)])
def test_the_repaired_force_descends_the_quadratic_potential(goal: tuple[float, float], yaw: float) -> None:
    def potential(x: float, y: float) -> float:
        return 0.5 * REPAIRED.alpha * ((x - goal[0]) ** 2 + (y - goal[1]) ** 2)

    h = 1e-4
    x, y = 3.0, -2.0
    gradient = [
        (potential(x + h, y) - potential(x - h, y)) / (2 * h),
        (potential(x, y + h) - potential(x, y - h)) / (2 * h),
    ]
    world = rotation(yaw) @ force(x, y, yaw, goal, STRAIGHT, REPAIRED)
    assert world == pytest.approx(-np.array(gradient), abs=1e-5)


def test_the_printed_angle_is_right_only_for_a_goal_ahead_along_x_at_yaw_zero() -> None:
    def angle(goal: tuple[float, float], yaw: float) -> float:
        x, y = force(0.0, 0.0, yaw, goal, STRAIGHT, PRINTED)
        assert hypot(x, y) == pytest.approx(1.3 * hypot(*goal))  # alpha r
        return degrees(atan2(y, x))

    assert angle((100.0, 5.0), 0.0) == pytest.approx(2.862, abs=1e-3)
    assert angle((-100.0, 5.0), 0.0) == pytest.approx(-2.862, abs=1e-3)  # the goal lies at 177 deg
    assert angle((100.0, 5.0), radians(30.0)) == pytest.approx(2.862, abs=1e-3)  # blind to the vehicle's own yaw
