"""How long an obstacle is: the way back begins behind its end."""

import numpy as np
from lane_planner import geometry

from vpf_sim.planning.lane.frame import Lane, LaneObstacles

LANE = Lane(y_m=0.0, right_m=5.25, left_m=-8.75, heading_rad=0.0, curvature_per_m=0.0)


def weights(bodies: LaneObstacles) -> list[float]:
    weight: list[float] = geometry(bodies).weight.tolist()
    return weight


def test_what_is_as_wide_as_a_truck_is_as_long_though_nothing_is_seen_of_its_side() -> None:
    """Our rear 5 m past the faces of a car 2.1 m wide and a truck 2.5 m wide, without parts; and 9 m past both."""
    along, left, right = np.full(2, -7.25), np.array([-3.4, 1.3]), np.array([-1.3, 3.8])
    assert weights(LaneObstacles(along, left, right)) == [0.0, 1.0]
    assert weights(LaneObstacles(along - 4.0, left, right)) == [0.0, 0.0]
