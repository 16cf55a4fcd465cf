"""Past obstacles that move, or behind them: when they count, on which side, how near, and how fast."""

from dataclasses import replace

import numpy as np
import pytest
from lane_planner import (
    BRAKING,
    BUMPER_M,
    CAR,
    CLEARANCE,
    SPEED,
    SPEED_MPS,
    geometry,
    lane_reference,
    lateral_cost,
    straight_lane,
)

from vpf_sim.planning.lane.frame import LaneObstacles
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry

LANE = straight_lane()


def obstacle(along_m: float, y_m: float, speed_mps: float) -> LaneObstacles:
    return LaneObstacles(*(np.array([value]) for value in (along_m, y_m - 0.9, y_m + 0.9, speed_mps)))


def about(*bodies: LaneObstacles) -> ObstacleGeometry:
    all_of_them = (np.concatenate([getattr(one, name) for one in bodies]) for name in LaneObstacles.__slots__)
    return geometry(LaneObstacles(*all_of_them))


def test_a_slow_lead_is_overtaken_and_one_that_runs_away_is_not() -> None:
    assert abs(lateral_cost().update(LANE, about(obstacle(12.0, 0.3, 3.0))).minimum_m) > 1.5
    for speed_mps in (5.5, 9.0):
        assert lateral_cost().update(LANE, about(obstacle(12.0, 0.3, speed_mps))).minimum_m == pytest.approx(
            0.0, abs=0.05
        )


def test_no_car_is_cut_off() -> None:
    """The car would go back from the lane to the left; the obstacle is beside, passed, or behind and faster."""
    left = replace(LANE, y_m=-3.5)
    for along_m, speed_mps, free in ((-4.0, 3.0, False), (-10.0, 3.0, True), (-20.0, 9.0, False), (6.0, 9.0, False)):
        watch = lateral_cost(-3.5)
        assert (watch.update(left, about(obstacle(along_m, 0.0, speed_mps))).minimum_m > -1.0) == free


@pytest.mark.parametrize("speed_mps", [2.0, 4.0])
def test_an_obstacle_that_cannot_be_passed_is_followed_at_its_gap(speed_mps: float) -> None:
    """v_d is the obstacle's speed at the wanted gap, less nearer by, more farther off; 0 behind a static one."""
    kept = BUMPER_M + BRAKING.standoff_m + SPEED.time_gap_s * speed_mps

    def wanted(along_m: float, body_mps: float, own_mps: float) -> float:
        return lane_reference().update(LANE, about(obstacle(along_m, 0.0, body_mps)), 0.0, 0.0, own_mps).speed_mps

    assert wanted(kept, speed_mps, speed_mps) == pytest.approx(speed_mps, abs=1e-6)
    assert wanted(kept - 1.0, speed_mps, speed_mps) < speed_mps - 0.1
    assert speed_mps < wanted(kept + 1.0, speed_mps, SPEED_MPS) <= SPEED_MPS
    assert wanted(BUMPER_M + BRAKING.standoff_m, 0.0, SPEED_MPS) == 0.0
    assert wanted(60.0, speed_mps, SPEED_MPS) == SPEED_MPS


@pytest.mark.parametrize(("speed_mps", "room_m", "crosses"), [(3.0, 2.0, False), (3.0, 9.0, True), (5.4, 2.5, True)])
def test_the_car_does_not_change_sides_behind_an_obstacle_that_is_reached_meanwhile(
    speed_mps: float, room_m: float, crosses: bool
) -> None:
    """An obstacle ahead in the lane to the right; a static one blocks the own lane and the one to the left."""
    along_m = 0.5 * CAR.length_m + room_m
    ahead = obstacle(along_m, 3.5, speed_mps)
    watch = lateral_cost(0.0)
    wall = LaneObstacles(*(np.array([value]) for value in (14.0, -12.0, 1.0, 0.0)))
    wide = replace(LANE, right_m=12.0, left_m=-12.0)
    assert (watch.update(wide, about(ahead, wall)).minimum_m > 4.4) == crosses


def test_straight_behind_an_obstacle_that_moves_no_side_is_decided_yet() -> None:
    """It is detected late, a hand's breadth to the left of our middle, where another leaves no room to its right."""
    bumper_m = 0.5 * CAR.length_m
    lead, right = obstacle(bumper_m + 6.8, -0.15, 3.1), obstacle(bumper_m + 2.0, 3.2, 3.9)
    assert lateral_cost(0.0).update(LANE, about(lead, right)).minimum_m < -2.0
    beside = replace(LANE, y_m=1.0)
    assert lateral_cost(1.0).update(beside, about(lead, right)).minimum_m > 0.5


def test_what_is_met_later_does_not_push_the_path_to_what_is_being_passed() -> None:
    """A car beside us on the left; one almost as fast far ahead to the right, so that both cannot be kept clear of."""
    beside, far = obstacle(1.0, -1.0, 3.0), obstacle(17.0, 2.6, 4.2)
    wanted = lateral_cost().update(replace(LANE, y_m=1.6), about(beside)).minimum_m
    assert lateral_cost(1.6).update(replace(LANE, y_m=1.6), about(beside, far)).minimum_m == pytest.approx(
        wanted, abs=0.1
    )


def test_a_path_is_not_brought_nearer_to_an_obstacle_that_is_being_passed_than_is_wanted() -> None:
    passed = obstacle(2.0, -1.0, 3.0)
    clear = -0.1 + 0.5 * CAR.width_m + CLEARANCE.wanted_m
    assert about(passed).kept_beside(2.0, 0.3) == pytest.approx(clear)
    assert about(passed).kept_beside(2.0, 1.8) == 1.8
    assert about(passed).kept_beside(1.2, 0.3) == 1.2
    assert about(obstacle(9.0, -1.0, 3.0)).kept_beside(2.0, 0.3) == 0.3
    mirrored = obstacle(2.0, 1.0, 3.0)
    assert about(mirrored).kept_beside(-2.0, -0.3) == pytest.approx(-clear)
