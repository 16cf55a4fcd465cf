"""Axes and rotation of the total force, as printed and repaired, at three headings of the road."""

from dataclasses import replace
from math import atan2, degrees, radians

import numpy as np
import pytest
from paper_planner import PAPER

from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.paper.total_field import TotalFieldConfig, compose, to_world

REPAIRED = replace(PAPER.total_field, lambda_x=0.5, lambda_y=0.25)
PRINTED = replace(REPAIRED, axes="printed", rotation="printed")
AHEAD = np.array([10.0, 0.0])


@pytest.mark.parametrize("heading", [0.0, 30.0, 90.0])
def test_straight_ahead_stays_straight_ahead_only_with_the_repaired_rotation(heading: float) -> None:
    yaw = radians(heading)

    def direction(config: TotalFieldConfig) -> float:
        x, y = to_world(AHEAD, yaw, config)
        return degrees(atan2(y, x))

    assert direction(REPAIRED) == pytest.approx(heading)
    assert direction(PRINTED) == pytest.approx(-heading)  # wrong by twice the heading, unless the road lies along X


def test_image_x_steers_only_when_it_is_mapped() -> None:
    to_the_right = np.array([3.0, 1.0])  # F_rep: an obstacle on the right, and its sum of TTC
    none = np.zeros(2)
    assert compose(AHEAD, to_the_right, none, REPAIRED).total == pytest.approx([10.0 - 1.0, -3.0])
    assert compose(AHEAD, to_the_right, none, PRINTED).total == pytest.approx([10.0 - 3.0, -1.0])


def test_the_road_weighs_by_lambda_and_the_parts_add_up() -> None:
    force = compose(AHEAD, np.array([1.0, 2.0]), np.array([4.0, 8.0]), REPAIRED)
    assert force.road == pytest.approx([-2.0, -2.0])
    assert force.total == pytest.approx(force.target + force.obstacle + force.road)


def test_turning_the_world_turns_the_repaired_force() -> None:
    force = np.array([3.0, -2.0])
    x, y = to_world(force, 0.3, REPAIRED)
    turned_x, turned_y = to_world(force, 0.3 + 2.4, REPAIRED)
    assert wrap_angle(atan2(turned_y, turned_x) - atan2(y, x) - 2.4) == pytest.approx(0.0, abs=1e-12)
