"""Axes and rotation of the total force, as printed and repaired, at three headings of the road."""

from dataclasses import replace
from math import atan2, cos, degrees, radians, sin

import numpy as np
import pytest
from paper_planner import PAPER

from vpf_sim.planning.paper.total_field import TotalFieldConfig, compose, to_world

REPAIRED = replace(PAPER.total_field, lambda_x=0.5, lambda_y=0.25)
PRINTED = replace(REPAIRED, axes="printed", rotation="printed")
AHEAD = np.array([10.0, 0.0])


@pytest.mark.parametrize("own", [0.0, -33.0])
@pytest.mark.parametrize("heading", [0.0, 30.0, 90.0])
def test_straight_ahead_stays_straight_ahead_only_with_the_repaired_rotation(heading: float, own: float) -> None:
    """So does a force at an angle of its own to the vehicle."""

    def direction(config: TotalFieldConfig) -> float:
        x, y = to_world(7.0 * np.array([cos(radians(own)), sin(radians(own))]), radians(heading), config)
        return degrees(atan2(y, x))

    assert direction(REPAIRED) == pytest.approx(own + heading)
    assert direction(PRINTED) == pytest.approx(own - heading)  # wrong by twice the heading, unless it is 0


def test_image_x_steers_only_when_it_is_mapped() -> None:
    to_the_right = np.array([3.0, 1.0])  # F_rep: an obstacle on the right, and its sum of TTC
    none = np.zeros(2)
    assert compose(AHEAD, to_the_right, none, REPAIRED).total == pytest.approx([10.0 - 1.0, -3.0])
    assert compose(AHEAD, to_the_right, none, PRINTED).total == pytest.approx([10.0 - 3.0, -1.0])


def test_the_road_weighs_by_lambda_and_the_parts_add_up() -> None:
    force = compose(AHEAD, np.array([1.0, 2.0]), np.array([4.0, 8.0]), REPAIRED)
    assert force.road == pytest.approx([-2.0, -2.0])
    assert force.total == pytest.approx(force.target + force.obstacle + force.road)
