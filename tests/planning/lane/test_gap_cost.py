"""Gaps in a row: between two obstacles, and between one and an edge of the road."""

import numpy as np
import pytest

from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.gap_cost import narrowness

ROAD = Lane(y_m=0.0, right_m=5.0, left_m=-5.0, heading_rad=0.0, curvature_per_m=0.0)
PLACES_M = np.linspace(-4.75, 4.75, 20)
WIDTHS_M = (2.0, 5.0)


def narrow(sides_m: list[tuple[float, float]], weights: list[float]) -> dict[float, float]:
    """Where it is narrow, of obstacles in one row between these sides."""
    left, right = np.array(sides_m).T
    bodies = LaneObstacles(np.full(len(left), 12.0), left, right)
    one_row = np.ones((len(left), len(left)), np.bool_)
    found = narrowness(bodies, one_row, np.array(weights), ROAD, PLACES_M, WIDTHS_M)
    return {float(y): round(float(value), 9) for y, value in zip(PLACES_M, found, strict=True) if value > 0.0}


def test_a_gap_beside_an_edge_is_one_between_two_obstacles() -> None:
    beside_edge = narrow([(-5.0, 2.0)], [1.0])
    between = narrow([(-5.0, 2.0), (5.0, 9.0)], [1.0, 1.0])
    assert beside_edge == between == dict.fromkeys(PLACES_M[PLACES_M > 2.0].tolist(), 0.4)
    mirrored = narrow([(-2.0, 5.0)], [1.0])
    assert mirrored == {-y: value for y, value in beside_edge.items()}


@pytest.mark.parametrize("gap_m", [1.9, 5.1])
def test_what_is_wide_and_what_is_no_gap_at_all_costs_nothing(gap_m: float) -> None:
    assert not narrow([(-5.0, 5.0 - gap_m)], [1.0])


def test_an_obstacle_that_counts_in_part_makes_a_gap_that_does() -> None:
    assert set(narrow([(-5.0, 2.0)], [0.5]).values()) == {0.2}
    assert set(narrow([(-5.0, -1.0), (2.0, 5.0)], [1.0, 0.25]).values()) == {0.1}
