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
    LIMITS,
    RATE_HZ,
    ROBUST,
    SETUP,
    SPEED,
    SPEED_MPS,
    geometry,
    lateral_path,
    speed_limits,
    straight_lane,
    unwrap,
)

from vpf_sim.braking import comfortable_speed, hard_excess
from vpf_sim.controllers.gtsmc import load_gains
from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.lateral_path import LateralPath
from vpf_sim.planning.lane.speed.limits import SpeedLimits
from vpf_sim.types import Floats

LOOK = unwrap(SPEED.look)
NEAR_M, TURNS_M, FULL_MPS2 = SPEED.near_m, SPEED.turn_m, CAR.full_brake_mps2
FIRM_MPS2, MET_S = unwrap(SPEED.firm_mps2), unwrap(SPEED.headed_s)
FALL_BACK_MPS, FAR_STANDOFF_M = SPEED.fall_back_mps, unwrap(SPEED.far_standoff_m)
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


def test_the_narrower_the_gap_the_slower_and_without_a_jump() -> None:
    gaps = np.linspace(CLEARANCE.least_m + 1e-6, CLEARANCE.full_speed_m + 0.05, 50)
    speeds = np.array([wanted(gate(gap, 2.0)) for gap in gaps])
    assert speeds[0] == pytest.approx(ROBUST.limits.walking_mps, abs=1e-3)
    assert speeds[-1] == SPEED_MPS
    assert np.all(np.diff(speeds) >= 0.0)
    assert np.diff(speeds).max() < 0.15
    assert wanted(gate(CLEARANCE.least_m - 0.01, 1.0)) == 0.0  # no longer far enough for a stop in comfort


def test_a_gap_is_left_as_slowly_as_it_is_entered() -> None:
    """Until the rear has passed the obstacles, which are 3.5 m long at least."""
    through = 2.0 * BUMPER_M + ROBUST.obstacles.length_m
    before, beside, past = (wanted(gate(NARROW_M, way_m)) for way_m in (0.5, 0.1 - through, -0.1 - through))
    assert beside == pytest.approx(before, abs=1e-6)
    assert before < SPEED_MPS == past


def test_what_a_gap_allows_does_not_depend_on_the_speed_that_the_car_has() -> None:
    speeds = [wanted(gate(NARROW_M, 2.0), ROBUST.limits.walking_mps + off) for off in (-0.01, 0.01)]
    assert speeds[0] == speeds[1] > ROBUST.limits.walking_mps


def walk(half_width_m: float, way_m: float, seconds: float) -> Floats:
    """(N,) m left to an obstacle ahead of a car that follows what is wanted as the controller does."""
    speed, watch, left = SPEED_MPS, speed_limits(), []
    for _ in range(round(seconds * RATE_HZ)):
        body = LaneObstacles(*np.array([[way_m + BUMPER_M, -half_width_m, half_width_m]]).T)
        error = watch.update(LANE, geometry(body), 0.0, speed) - speed
        speed = max(0.0, speed + 3.6 * min(max(error, -1.0), 1.0) / RATE_HZ)
        way_m -= speed / RATE_HZ
        left.append(way_m)
    return np.array(left)


def test_the_car_stops_and_looks_where_it_can_still_get_aside_before_it_walks_up_to_what_blocks_it() -> None:
    """An obstacle 1.6 m wide with a side 1.87 m aside, and a wider one."""
    side = 0.8 + HALF_M + CLEARANCE.least_m
    least = float(LIMITS.least_way(np.array([side]))[0])
    assert LIMITS.largest_shift(np.array([least]))[0] == pytest.approx(side)
    for half_width_m, first in ((0.8, min(least, FAR_STANDOFF_M)), (3.0, FAR_STANDOFF_M)):
        left = walk(half_width_m, 12.0, 60.0)
        stops = np.array([first, BRAKING.standoff_m, BRAKING.closest_standoff_m])
        rests = left[np.flatnonzero(np.abs(np.diff(left)) < 1e-5)]
        beyond = stops[None] - rests[:, None]  # the car's speed falls a little late
        near = (beyond > -0.05) & (beyond < 0.35)
        assert near.any(axis=1).all()
        assert near.any(axis=0).all()


def test_short_stands_do_not_add_up() -> None:
    watch, walls = speed_limits(), geometry(LaneObstacles(*np.array([[5.0, -1.0, 1.0]]).T))
    for second in range(10):
        for _ in range(round(2.0 * RATE_HZ)):
            assert watch.update(LANE, walls, 0.0, 0.0) == 0.0, second
        for _ in range(round(0.5 * RATE_HZ)):
            watch.update(LANE, walls, 0.0, 0.5)


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


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_car_that_is_headed_at_an_obstacle_leaves_the_time_to_turn_away_from_it(side: float) -> None:
    """Where the car is it is clear of the obstacle, and shall stay: but as it is headed now it would meet it."""

    def towards(slope: float, body_mps: float, speed_mps: float) -> float:
        sides = sorted((side * (HALF_M + 0.5), side * 4.0))
        body = LaneObstacles(*(np.array([one]) for one in (BUMPER_M + 1.5, *sides, body_mps)))
        lane = Lane(0.0, 9.0, -9.0, -np.arctan(side * slope), 0.0)
        return speed_limits().update(lane, geometry(body), 0.0, speed_mps)

    assert towards(0.25, 0.0, 2.5) == pytest.approx(1.5 / MET_S)  # its face
    assert towards(0.1, 0.0, 4.5) == pytest.approx((0.5 / 0.1 - BUMPER_M) / MET_S)  # its flank, farther behind
    assert towards(0.1, 0.0, 5.5) == comfortable_speed(5.5)  # in comfort
    assert towards(-0.1, 0.0, 4.5) > 4.4
    assert towards(0.1, 4.0, 4.5) > 4.4


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


def straightened(obstacles: LaneObstacles, path: LateralPath) -> float:
    """v_d where only the steering slows a path, which need not come to rest."""
    limits = SpeedLimits(replace(SPEED, rest_m=None), ROBUST, SETUP, LIMITS)
    return limits.update(LANE, geometry(obstacles), 0.0, 2.0, path)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_wheels_are_straight_before_the_path_is_too_steep(side: float) -> None:
    """On p + b^2 / (2 j) the path is headed most steeply at the wall beside it, and not at all where it is straight."""
    wall = LaneObstacles(*(np.array([one]) for one in (BUMPER_M - 3.0, *sorted((side * 2.0, side * 5.0)))))
    glide = lateral_path(0.0, 5.0)
    glide.slope, glide.bend_per_m = side * 0.05, side * 0.12
    speed_mps = straightened(wall, glide)
    assert ROBUST.limits.walking_mps < speed_mps < SPEED_MPS
    allowed = LIMITS.path_between(geometry(wall).between(LANE, 0.0), 0.0)[side > 0.0]
    assert 0.05 + 0.12**2 / (2.0 * LIMITS.steering(np.array([speed_mps]))[0]) == pytest.approx(allowed + 0.02, abs=0.01)
    glide.slope, glide.bend_per_m = side * 0.3, 0.0
    assert straightened(wall, glide) > SPEED_MPS - 0.1


def test_a_car_that_speeds_up_in_a_swerve_does_not_turn_on_towards_what_is_beside() -> None:
    """A wall on either side of a path that bends towards one: the faster, the later the wheels are straight."""
    wall = [(BUMPER_M - 3.0, 3.0, 5.0)]
    steep, gentle = (bent(wall, 0.0, (0.0, 0.15, bend), False) for bend in (0.15, 0.02))
    assert steep == bent(wall, 0.0, (0.0, 0.15, 0.15), True) < gentle


def bent(
    rows: list[tuple[float, float, float]], minimum_m: float, path: tuple[float, float, float], mirrored: bool
) -> float:
    """v_d at 5 m/s on a path (y, slope, bend) before obstacles (face, left, right), or mirrored."""
    sign = -1.0 if mirrored else 1.0
    sides = [(face, *sorted((sign * left, sign * right))) for face, left, right in rows]
    y_m, slope, bend = (sign * one for one in path)
    glide = lateral_path(y_m, 5.0)
    glide.slope, glide.bend_per_m = slope, bend
    lane = Lane(y_m, 9.0, -9.0, -slope, 0.0)
    return speed_limits().update(lane, geometry(LaneObstacles(*np.array(sides).T)), sign * minimum_m, 5.0, glide)


def test_a_path_that_would_run_wide_into_what_stands_beyond_the_gap_is_slowed_and_its_mirror_image_alike() -> None:
    beyond = [(BUMPER_M + 3.0, 1.5 + HALF_M + 0.5, 5.0)]
    path = (1.2, 0.35, 0.05)
    assert bent(beyond, 1.5, path, False) == pytest.approx(2.5)  # no more below 5 m/s than comfort lets it
    assert bent(beyond, 1.5, path, True) == bent(beyond, 1.5, path, False)
    assert bent([(BUMPER_M + 3.0, 7.0, 8.0)], 1.5, path, False) > 5.0


@pytest.mark.parametrize(("y_m", "slope", "bend"), [(1.6, 0.3, -0.05), (2.0, 0.2, -0.08), (2.25, 0.1, -0.05)])
def test_a_path_that_leads_away_from_the_only_obstacle_is_not_slowed_by_how_it_comes_to_rest(
    y_m: float, slope: float, bend: float
) -> None:
    passed = [(BUMPER_M + 0.5, -1.0, 1.0)]
    straight = speed_limits().update(
        Lane(y_m, 9.0, -9.0, -slope, 0.0), geometry(LaneObstacles(*np.array(passed).T)), 2.3, 5.0
    )
    assert bent(passed, 2.3, (y_m, slope, bend), False) == straight


def test_a_wall_on_both_sides_slows_a_path_to_the_left_as_one_to_the_right() -> None:
    wall = [(7.0, -5.0, 5.0)]
    assert bent(wall, 0.0, (0.0, 0.2, 0.0), False) == bent(wall, 0.0, (0.0, 0.2, 0.0), True)


def test_a_gap_that_proves_narrow_beside_the_car_is_no_reason_to_brake_beyond_comfort() -> None:
    for gap_m in (0.17, 0.13, 0.0):
        assert wanted(gate(gap_m, -1.0), 5.0) >= comfortable_speed(5.0)


def test_the_nearer_side_is_one_where_no_other_obstacle_stands() -> None:
    """Two obstacles without room between them; their outer sides are 3.5 and 4.5 m from the middle."""
    rows = np.array([(8.0, -1.0, 0.9), (8.0, 1.5, 2.5)])
    free = geometry(LaneObstacles(*rows.T)).nearer_side(LANE)
    assert free[0] == pytest.approx(1.0 + HALF_M + CLEARANCE.least_m)
    to_the_left = np.array([(8.0, -1.0, 0.9), (8.0, -3.0, -1.5)])
    assert geometry(LaneObstacles(*to_the_left.T)).nearer_side(LANE)[0] == pytest.approx(
        0.9 + HALF_M + CLEARANCE.least_m
    )
    both = np.array([(8.0, -1.0, 0.9), (8.0, 1.5, 9.0), (8.0, -9.0, -1.5)])
    assert np.all(geometry(LaneObstacles(*both.T)).nearer_side(LANE) == 0.0)
