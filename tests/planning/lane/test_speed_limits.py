"""The speed by what is ahead: between obstacles, and when standing before what blocks the way."""

from dataclasses import replace

import numpy as np
import pytest
from lane_planner import (
    BRAKING,
    BUMPER_M,
    CAR,
    CLEARANCE,
    HALF_M,
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


def test_the_controller_brakes_hard_from_where_the_planner_asks_for_it() -> None:
    assert hard_excess(50.0) == load_gains("robust").hard_braking_error_mps


def test_a_gap_that_proves_narrow_beside_the_car_is_no_reason_to_brake_beyond_comfort() -> None:
    for gap_m in (0.17, 0.13, 0.0):
        assert wanted(gate(gap_m, -1.0), 5.0) >= comfortable_speed(5.0)
