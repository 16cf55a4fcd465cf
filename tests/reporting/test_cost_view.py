"""The cost view: dark where the cost is low, with the reference marked."""

from dataclasses import replace

import numpy as np
import pytest
from test_overlay import plan

from vpf_sim.errors import InputError
from vpf_sim.planning.lane.frame import NOTHING, Lane
from vpf_sim.planning.lane.lateral_cost import CostProfile
from vpf_sim.planning.lane.planner import LanePlan
from vpf_sim.reporting import plan_view
from vpf_sim.reporting.top_view import REFERENCE
from vpf_sim.types import Camera, Plan

LEFT_M, RIGHT_M, WIDTH_PX = -8.75, 5.25, 640


def bowl(minimum_m: float) -> Plan:
    """A plan whose cost is a parabola about its minimum."""
    y = np.linspace(-9.0, 9.0, 361)
    none = np.zeros_like(y)
    cost = CostProfile(y, 0.1 * (y - minimum_m) ** 2, none, none, minimum_m)
    lane = Lane(0.0, RIGHT_M, LEFT_M, 0.0, 0.0)
    return replace(plan(Camera()), extra=LanePlan(lane, NOTHING, cost, minimum_m))


def column(y_m: float) -> int:
    margin = plan_view.MARGIN_M
    return round((y_m - LEFT_M + margin) * WIDTH_PX / (RIGHT_M - LEFT_M + 2.0 * margin))


@pytest.mark.parametrize("minimum_m", [-6.0, 0.0, 3.5])
def test_the_picture_is_darkest_beside_the_minimum_and_marks_it(minimum_m: float) -> None:
    picture = plan_view.draw(bowl(minimum_m), WIDTH_PX)
    row = picture[60].astype(int)
    assert row[column(minimum_m)].tolist() == list(REFERENCE)
    brightness = row.sum(axis=1)
    beside, away = brightness[column(minimum_m) + 8], brightness[column(minimum_m + (4.0 if minimum_m < 0 else -4.0))]
    assert beside < away


def test_a_plan_without_a_lateral_cost_is_refused() -> None:
    with pytest.raises(InputError, match="expected a plan with a lateral cost"):
        plan_view.draw(plan(Camera()))
