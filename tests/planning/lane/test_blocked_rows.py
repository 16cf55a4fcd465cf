"""Rows whose gap is blocked by what is behind the first of them: it is detected late, and then no path leads back."""

from math import sqrt

import numpy as np
import pytest
from ideal import Body, Road
from lane_planner import BRAKING, BUMPER_M, HALF_M, RATE_HZ, ROBUST, SPEED, geometry, speed_limits, unwrap
from test_closed_loop import drive
from test_speed_limits import FULL_MPS2, LANE, NEAR_M, TURNS_M, wanted

from vpf_sim.braking import comfortable_speed, hard_excess
from vpf_sim.planning.lane.frame import LaneObstacles
from vpf_sim.planning.lane.speed.creep import STAGES
from vpf_sim.types import Bools

ROW_S_M = 60.0
TRUCK_M, LOW_M = 2.5, 1.2  # a truck's width, a pallet's length
# Rows about one place of the road, in which the seen gap is blocked; the free side is that beyond the truck.
PALLET_AND_CONE = (
    Body(ROW_S_M, -2.45, 8.5, TRUCK_M),
    Body(ROW_S_M, 0.75, LOW_M, 0.8, told_m=10.0),
    Body(ROW_S_M, 3.65, 0.4, 0.4, told_m=10.0),
)
PEDESTRIAN_BETWEEN_TRUCKS = (
    Body(ROW_S_M, -2.7, 8.5, TRUCK_M),
    Body(ROW_S_M, 3.7, 8.5, TRUCK_M),
    Body(ROW_S_M, 0.1, 0.4, 0.5, told_m=8.2),
)


@pytest.mark.parametrize(
    ("bodies", "curvature_per_m"),
    [(PALLET_AND_CONE, 0.0), (PALLET_AND_CONE, 0.005), (PEDESTRIAN_BETWEEN_TRUCKS, -0.005)],
)
def test_a_row_that_is_shut_behind_its_first_is_passed_on_the_free_side(
    bodies: tuple[Body, ...], curvature_per_m: float
) -> None:
    run = drive(Road(curvature_per_m), bodies, ROW_S_M + 15.1, time_s=75.0)
    assert run.track[0, -1] >= ROW_S_M + 15.0
    assert run.clearance_m > 0.1


def row(*bodies: tuple[float, float, float]) -> LaneObstacles:
    """Each by the way to its face, and its left and right side."""
    way, left, right = np.array(bodies).T
    return LaneObstacles(way + BUMPER_M, left, right)


def blocked(bodies: LaneObstacles) -> Bools:
    """(K,) which stand in a row that leaves no way through where the car is."""
    return geometry(bodies).blocked_rows(0.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("gap_m", "behind_m", "is_blocked"), [(0.1, 3.6, True), (0.2, 3.6, True), (0.3, 3.6, False)])
def test_what_stands_behind_the_first_must_leave_more(
    side: float, gap_m: float, behind_m: float, is_blocked: bool
) -> None:
    """A truck 1 m beside the car, an obstacle behind its face on the other side; alone, 0.2 m would be enough."""
    truck = (5.0, *sorted((side * (HALF_M + 1.0), side * (HALF_M + 3.5))))
    behind = (5.0 + behind_m, *sorted((-side * (HALF_M + gap_m), -side * (HALF_M + gap_m + 0.8))))
    assert blocked(row(truck, behind)).all() == is_blocked
    assert blocked(row(behind)).any() == (gap_m < 0.12)
    nearer = (behind_m - 2.0, *behind[1:])
    assert not blocked(row(truck, nearer)).any() or gap_m < 0.12, "the first of the row"


def test_an_obstacle_of_another_row_or_beside_the_car_shuts_none() -> None:
    in_way = (-0.5, 0.5)
    truck = (5.0, HALF_M + 1.0, HALF_M + 3.5)
    far = row(truck, (5.0 + ROBUST.obstacles.long_m + 2.0, *in_way))
    assert blocked(far).tolist() == [False, True]
    assert blocked(row((-1.0, *truck[1:]), (3.0, *in_way))).tolist() == [False, True]


def test_the_car_stops_before_the_first_of_a_row_that_is_shut() -> None:
    """As before an obstacle in its way, until it has stood for long enough to walk up to what shuts the row."""
    truck, low = (3.5, HALF_M + 1.0, HALF_M + 3.5), (7.1, -0.5, 0.5)
    stop = sqrt(2.0 * BRAKING.comfort_mps2 * (3.5 - BRAKING.standoff_m))
    assert wanted(row(truck, low), 1.5) == pytest.approx(stop)
    assert wanted(row(low), 1.5) > stop
    watch, standing = speed_limits(), geometry(row((1.0, *truck[1:]), (4.6, *low[1:])))
    wants = [
        watch.update(LANE, standing, 0.0, 0.0)
        for _ in range(round((STAGES * unwrap(SPEED.creep).standing_s + 1.0) * RATE_HZ))
    ]
    assert wants[0] == 0.0
    assert wants[-1] == pytest.approx(unwrap(SPEED.creep).speed_mps)


def test_the_car_brakes_beyond_comfort_where_that_leaves_a_turn_and_not_where_it_does_not() -> None:
    """At 3 m/s, 3 m before a truck beside the way, v^2 / 2 (3.0 - 2.2) m is 5.6 m/s^2; 2.5 m before it is too late."""
    speed = 3.0
    low = (HALF_M - 1.4, HALF_M - 0.4)
    in_time, too_late, right_beside = (
        wanted(row((way, HALF_M + 1.0, HALF_M + 3.5), (way + 3.6, *low)), speed) for way in (3.0, 2.5, 1.2)
    )
    hard = (speed**2 / (2.0 * (3.0 - TURNS_M)) - 3.5) / (FULL_MPS2 - 3.5)
    assert 0.0 < hard < 1.0
    assert in_time == pytest.approx(speed - hard_excess(speed) - hard)
    assert (too_late, right_beside) == pytest.approx(2 * (comfortable_speed(speed),))
    assert speed**2 / (2.0 * (2.5 + 3.6 - NEAR_M)) < 3.5, "for what shuts the row there is way enough"
