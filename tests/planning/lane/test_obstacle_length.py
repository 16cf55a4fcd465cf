"""How long an obstacle is, from its parts: the way back begins behind the last of them."""

import numpy as np
import pytest
from lane_planner import ROBUST, geometry

from vpf_sim.planning.lane.frame import Lane, LaneObstacles, place
from vpf_sim.types import Obstacles

LANE = Lane(y_m=0.0, right_m=5.25, left_m=-8.75, heading_rad=0.0, curvature_per_m=0.0)


def reported(*rows: tuple[float, float, float]) -> Obstacles:
    """Standing obstacles of identities of their own: face, left and right side."""
    forward, left, right = np.array(rows).T
    count = len(rows)
    return Obstacles(
        forward_m=forward,
        left_m=left,
        right_m=right,
        sigma_m=np.full(count, 0.1),
        ttc_s=np.full(count, np.inf),
        identity=np.arange(count),
        speed_mps=np.zeros(count),
    )


def weights(bodies: LaneObstacles) -> list[float]:
    weight: list[float] = geometry(bodies).weight.tolist()
    return weight


def test_a_side_detected_in_parts_is_one_obstacle_as_long_as_they_reach() -> None:
    truck = place(reported((6.0, -4.4, -1.9), (8.4, -2.5, -1.9), (12.9, -2.5, -1.9)), LANE, ROBUST.obstacles.parts)
    assert len(truck) == 1
    assert truck.length_m == pytest.approx([6.9])


def test_obstacles_that_are_no_parts_have_no_length() -> None:
    alone = place(reported((6.0, -4.4, -1.9), (20.0, -4.4, -1.9), (8.0, 1.0, 2.0)), LANE, ROBUST.obstacles.parts)
    assert alone.length_m.tolist() == [0.0, 0.0, 0.0]


def test_the_way_back_begins_behind_the_last_part() -> None:
    """Face 6 m behind: a car of 5 m is passed, a truck of 8.5 m is still beside us."""
    rows = np.array([[-6.7, -3.4, -1.3]]).T
    car, truck = LaneObstacles(*rows), LaneObstacles(*rows, length_m=np.array([7.0]))
    assert weights(car) == [0.0]
    assert weights(truck) == [1.0]
    past = LaneObstacles(rows[0] - 3.0, *rows[1:], length_m=np.array([7.0]))
    assert weights(past) == [0.0]


def test_what_is_as_wide_as_a_truck_is_as_long_though_nothing_is_seen_of_its_side() -> None:
    """Our rear 5 m past the faces of a car 2.1 m wide and a truck 2.5 m wide, without parts; and 9 m past both."""
    along, left, right = np.full(2, -7.25), np.array([-3.4, 1.3]), np.array([-1.3, 3.8])
    assert weights(LaneObstacles(along, left, right)) == [0.0, 1.0]
    assert weights(LaneObstacles(along - 4.0, left, right)) == [0.0, 0.0]
