"""The speed by what is ahead: between obstacles, and when standing before what blocks the way."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from lane_planner import (
    BRAKING,
    BUMPER_M,
    CAR,
    CLEARANCE,
    HALF_M,
    ROBUST,
    SPEED,
    SPEED_MPS,
    geometry,
    speed_limits,
    straight_lane,
    unwrap,
)

from vpf_sim.braking import comfortable_speed, hard_excess
from vpf_sim.controllers.gtsmc import load_gains
from vpf_sim.planning.lane.frame import LaneObstacles

LOOK = unwrap(SPEED.look)
NEAR_M, TURNS_M, FULL_MPS2 = SPEED.near_m, SPEED.turn_m, CAR.full_brake_mps2
FIRM_MPS2 = unwrap(SPEED.firm_mps2)
FALL_BACK_MPS = SPEED.fall_back_mps
NARROW_M = 0.5 * (CLEARANCE.least_m + CLEARANCE.full_speed_m)
LANE = straight_lane()


def wanted(obstacles: LaneObstacles, speed_mps: float = 3.0) -> float:
    """v_d at first sight, the minimum being where the car is."""
    return speed_limits().update(LANE, geometry(obstacles), 0.0, speed_mps)


def gate(gap_m: float, way_m: float) -> LaneObstacles:
    """Two obstacles with the car's width and that gap on either side between them."""
    inner = HALF_M + gap_m
    rows = ((way_m + BUMPER_M, -inner - 2.0, -inner), (way_m + BUMPER_M, inner, inner + 2.0))
    return LaneObstacles(*np.array(rows).T)


def test_no_more_is_asked_for_than_comfort_gives_unless_an_obstacle_is_too_near_for_that() -> None:
    """A wall closes the road: the car shall stand either way, but the brakes go beyond comfort only if they must.

    They must to leave the way for a turn before the wall, where they can, and else not to touch it.
    """

    def before(way_m: float) -> float:
        return wanted(LaneObstacles(*np.array([[way_m + BUMPER_M, -9.0, 9.0]]).T), speed_mps)

    for speed_mps in np.linspace(2.6, 8.0, 12).tolist():
        least = comfortable_speed(speed_mps)
        firm_m, full_m = (0.5 * speed_mps**2 / brake for brake in (FIRM_MPS2, FULL_MPS2))
        assert before(TURNS_M + firm_m + 0.01) >= min(least, SPEED_MPS)
        assert before(TURNS_M + 0.5 * (firm_m + full_m)) < least
        if firm_m + 0.02 < TURNS_M - NEAR_M + full_m:
            assert before(TURNS_M + full_m - 0.01) == pytest.approx(least)
        assert before(NEAR_M + 0.5 * (firm_m + full_m)) < least
        assert before(min(NEAR_M + full_m, BRAKING.standoff_m) - 0.01) == 0.0


@pytest.mark.parametrize(("speed_mps", "body_mps", "way_m"), [(4.5, 3.1, 6.8), (5.55, 3.0, 4.0), (5.55, 2.0, 5.0)])
def test_an_obstacle_that_moves_and_is_detected_late_is_fallen_in_behind_in_comfort(
    speed_mps: float, body_mps: float, way_m: float
) -> None:
    """What counts is how fast it is come nearer to, not how fast the car is; too near, it is let go ahead."""
    lead = LaneObstacles(*(np.array([one]) for one in (way_m + BUMPER_M, -0.9, 0.9, body_mps)))
    assert speed_limits().update(LANE, geometry(lead), 0.0, speed_mps) >= comfortable_speed(speed_mps)
    too_near = replace(lead, along_m=np.array([NEAR_M + 0.1 + BUMPER_M]))
    assert speed_limits().update(LANE, geometry(too_near), 0.0, body_mps) == pytest.approx(body_mps - FALL_BACK_MPS)
    touching = replace(lead, along_m=np.array([0.1 + BUMPER_M]))
    assert speed_limits().update(LANE, geometry(touching), 0.0, speed_mps) < body_mps - FALL_BACK_MPS


def test_before_a_gap_that_one_obstacle_more_would_close_the_car_looks_while_a_turn_is_left() -> None:
    """A wall to the right edge but for the gap; as soon as a turn leads out no longer, on."""

    def towards(gap_m: float, way_m: float, speed_mps: float) -> float:
        wall = LaneObstacles(*(np.array([one]) for one in (way_m + BUMPER_M, -7.0, LANE.right_m - gap_m)))
        middle_m = LANE.right_m - 0.5 * gap_m
        lane = replace(LANE, y_m=middle_m)
        return speed_limits().update(lane, geometry(wall), middle_m, speed_mps)

    for way_m in (LOOK.ahead_m + 0.01, 6.0, 8.0):
        speed_mps = sqrt(LOOK.speed_mps**2 + 2.0 * BRAKING.comfort_mps2 * (way_m - LOOK.ahead_m))
        assert towards(3.4, way_m, speed_mps) == pytest.approx(speed_mps)
        assert towards(LOOK.gap_m + 0.1, way_m, SPEED_MPS) == SPEED_MPS
    for way_m in (LOOK.ahead_m - 0.01, TURNS_M + 0.01):
        assert towards(3.4, way_m, LOOK.speed_mps) == pytest.approx(LOOK.speed_mps)
    assert towards(3.4, TURNS_M - 0.01, SPEED_MPS) == SPEED_MPS


def test_a_gap_detected_late_is_looked_at_in_comfort_and_obstacles_behind_the_row_are_not_of_it() -> None:
    right = LANE.right_m - 4.0
    late = LaneObstacles(*(np.array([one]) for one in (LOOK.ahead_m + 0.1 + BUMPER_M, -7.0, right)))
    lane = replace(LANE, y_m=right + 2.0)
    assert speed_limits().update(lane, geometry(late), lane.y_m, 5.5) == pytest.approx(comfortable_speed(5.5))
    for behind_m, slowed in ((ROBUST.obstacles.row_depth_m - 0.1, True), (ROBUST.obstacles.row_depth_m + 0.1, False)):
        rows = np.array([[6.0 + BUMPER_M, -7.0, -1.5], [6.0 + behind_m + BUMPER_M, 2.0, 4.0]])
        assert (wanted(LaneObstacles(*rows.T), SPEED_MPS) < SPEED_MPS) is slowed


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_narrow_gap_behind_the_row_that_is_being_passed_is_slowed_down_for_in_time(side: float) -> None:
    """A truck beside the car, a cone farther on: after the last turn before the truck, its face changes nothing."""
    half_gap_m, cone_m = 2.2, 9.0

    def passing(truck_m: float) -> float:
        truck = (truck_m + BUMPER_M, *sorted((-side * half_gap_m, -side * 7.0)), 0.0)
        end = (cone_m + BUMPER_M, *sorted((-side * half_gap_m, -side * 3.0)), 0.0)
        cone = (cone_m + BUMPER_M, *sorted((side * half_gap_m, side * (half_gap_m + 0.4))), 0.0)
        return wanted(LaneObstacles(*np.array([truck, end, cone]).T), SPEED_MPS)

    expected = sqrt(LOOK.speed_mps**2 + 2.0 * BRAKING.comfort_mps2 * (cone_m - LOOK.ahead_m))
    assert expected < SPEED_MPS
    for truck_m in (TURNS_M - 0.1, 1.0, 0.01, -0.01, -1.0):
        assert passing(truck_m) == pytest.approx(expected)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_stands_farther_aside_before_an_obstacle_bounds_the_gap_with_it(side: float) -> None:
    """A wall 1.8 m beside our way, and farther on, .6 m beside it, a cone: no more than 4.4 m between them.

    The turn that is to be left is one before the wall.
    """
    cone_m = 12.0
    cone = (cone_m + BUMPER_M, *sorted((side * (HALF_M + 0.6), side * (HALF_M + 1.0))), 0.0)
    for wall_m, slowed in (
        (cone_m - ROBUST.obstacles.row_depth_m + 0.1, True),
        (cone_m - ROBUST.obstacles.row_depth_m - 0.1, False),
    ):
        wall = (wall_m + BUMPER_M, *sorted((-side * (HALF_M + 1.8), -side * 7.0)), 0.0)
        expected = (
            sqrt(LOOK.speed_mps**2 + 2.0 * BRAKING.comfort_mps2 * (wall_m - LOOK.ahead_m)) if slowed else SPEED_MPS
        )
        assert wanted(LaneObstacles(*np.array([wall, cone]).T), SPEED_MPS) == pytest.approx(expected)


def test_the_controller_brakes_hard_from_where_the_planner_asks_for_it() -> None:
    assert hard_excess(50.0) == load_gains("robust").hard_braking_error_mps


def test_a_gap_that_proves_narrow_beside_the_car_is_no_reason_to_brake_beyond_comfort() -> None:
    for gap_m in (0.17, 0.13, 0.0):
        assert wanted(gate(gap_m, -1.0), 5.0) >= comfortable_speed(5.0)
