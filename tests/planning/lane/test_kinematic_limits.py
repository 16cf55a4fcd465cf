"""How far aside the way that is left allows, and what is no choice: places off the road or behind a near obstacle."""

from dataclasses import replace
from math import hypot, inf

import numpy as np
import pytest
from bicycle import Bicycle
from lane_planner import (
    CAR,
    CLEARANCE,
    LIMITS,
    ROBUST,
    geometry,
    lateral_cost,
    straight_lane,
)

from vpf_sim.planning.lane.frame import NOTHING, Lane, LaneObstacles
from vpf_sim.planning.lane.lateral_cost import LateralCost
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.types import Command

LANE = straight_lane()


def bodies(*rows: tuple[float, float, float]) -> ObstacleGeometry:
    """Each by its face along the road, and its left and right side."""
    return geometry(LaneObstacles(*np.array(rows).T))


def field(lane: Lane = LANE) -> LateralCost:
    """One that has seen the empty road: it remembers to be where the car is."""
    one = lateral_cost()
    one.update(lane, geometry(NOTHING))
    return one


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_worst_obstacle_pushes_no_car_off_the_road(side: float) -> None:
    """A wall across all but 1.5 m at one edge: no place is free, and the lowest one still lies on the road."""
    lane = Lane(side * 3.0, 7.0, -7.0, 0.0, 0.0)
    left, right = sorted((-side * 7.0, side * 5.5))
    minimum = field(lane).update(lane, bodies((20.0, left, right))).minimum_m
    assert abs(minimum) + 0.5 * CAR.width_m <= 7.0 - CLEARANCE.edge_m + ROBUST.lateral_cost.spacing_m


def test_what_is_left_to_be_made_is_counted_to_the_side_that_was_chosen() -> None:
    """the car covers one by more to the right; a second is crossed on the way to the left, a third is not."""
    row, margin = bodies((10.0, -1.6, 0.6), (10.0, -4.8, -2.8), (10.0, 4.0, 5.0)), 0.5 * CAR.width_m + 0.25
    left = row.shift(0.0, -6.0, 0.25)
    assert left[:2] == pytest.approx([1.6 + margin, 4.8 + margin])
    assert left[2] <= 0.0
    right = row.shift(0.0, 0.6 + margin, 0.25)
    assert right[0] == pytest.approx(0.6 + margin)
    assert np.all(right[1:] <= 0.0)


def tightest(way_m: float) -> float:
    """m aside on a way at walking speed: full steering to the one side, then to the other until the heading is back."""
    best = 0.0
    for turn in np.linspace(0.2, 0.8, 13):
        car = Bicycle(speed_mps=ROBUST.limits.walking_mps)
        while car.x_m < way_m and -1e-3 < car.yaw_rad < 1.2:
            car.step(Command(0.0, 1.0 if car.x_m < turn * way_m else -1.0))
        if car.yaw_rad < 0.05:
            best = max(best, car.y_m)
    return best


@pytest.mark.parametrize("way_m", [3.0, 4.0, 6.0])
def test_what_is_in_reach_is_in_reach(way_m: float) -> None:
    reach = float(LIMITS.aside(np.array([way_m]))[0])
    assert 0.6 * tightest(way_m) < reach < tightest(way_m)


def test_the_way_decides_the_speed() -> None:
    """By t = sqrt(4.4 s / a), or by the steering's rate, and what the heading brings; inf where nothing is left."""
    way, shift = np.array([20.0, 5.0, 20.0, 3.0, 3.0]), np.array([1.0, 1.0, -0.2, 2.0, 0.0])
    speed = LIMITS.speed(way, shift, 0.0, 0.0)
    assert speed[0] == pytest.approx(20.0 / (np.sqrt(4.4 / ROBUST.limits.acceleration_mps2) + 0.3))
    assert LIMITS.steering(speed[1]) == pytest.approx(15.0 / (5.0 - 0.3 * speed[1]) ** 3, rel=0.05)
    assert speed[2] == inf
    assert speed[3] < ROBUST.limits.walking_mps
    assert speed[4] == inf
    assert LIMITS.reaches(way, shift, 0.0).tolist() == [True, True, True, False, True]
    assert LIMITS.reaches(way[3:4], shift[3:4], 0.55)[0]


@pytest.mark.parametrize("slope", [0.0, 0.1, 0.45])
@pytest.mark.parametrize("way_m", [0.1, 2.0])
def test_a_turned_car_that_goes_straight_on_clears_what_that_brings(way_m: float, slope: float) -> None:
    """Its side, a straight line along its heading half a width from the pose, at the obstacle's face."""
    heading, side = np.arctan(slope), 0.5 * CAR.width_m
    sine, cosine = np.sin(heading), np.cos(heading)
    ahead = way_m + 0.5 * CAR.length_m
    at_face = -side * cosine + (ahead - side * sine) * sine / cosine
    assert LIMITS.brought(np.array([way_m]), slope)[0] == pytest.approx(at_face + side)


@pytest.mark.parametrize("speed_mps", [3.0, 5.0])
def test_a_car_that_is_on_the_way_aside_already_is_as_far_as_one_that_began_before(speed_mps: float) -> None:
    """Headed at a slope on the curve of least radius, as if from straight on a way longer by R slope."""
    slope, shift, radius = 0.2, 2.0, float(1.0 / LIMITS.tightest(speed_mps))
    whole = shift + 0.5 * radius * slope**2
    way = (
        float(LIMITS.limits(speed_mps).way(whole))
        - radius * slope
        + 0.3 * speed_mps * (1.0 - slope / float(LIMITS.ratio(speed_mps)))
    )
    assert LIMITS.speed(np.array([way]), np.array([shift]), 0.0, slope)[0] == pytest.approx(speed_mps, rel=0.02)


def test_the_first_half_of_a_shift_to_a_far_goal_takes_half_of_its_way() -> None:
    """The car need not rest where it is clear of an obstacle, if its path leads on."""
    way, half = np.array([8.0]), np.array([1.0])
    rests, goes_on = LIMITS.speed(way, half, 0.0, 0.0)[0], LIMITS.speed(way, half, 2.0, 0.0)[0]
    assert 0.5 * float(LIMITS.limits(goes_on).way(2.0)) + 0.3 * goes_on == pytest.approx(8.0, rel=0.03)
    assert goes_on > 1.1 * rests


def test_near_an_edge_the_car_turns_no_more_than_its_corners_allow() -> None:
    for gap in (0.3, 0.8, 1.5):
        lane = replace(LANE, y_m=LANE.right_m - 0.5 * CAR.width_m - gap)
        left, right = LIMITS.between(lane, 1.0)
        assert left == ROBUST.limits.walking_ratio
        corner = (
            0.5 * hypot(CAR.length_m, CAR.width_m) * np.sin(np.arcsin(right) + np.arctan(CAR.width_m / CAR.length_m))
        )
        assert corner < 0.5 * CAR.width_m + gap


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("gap_m", "passes"), [(2.3, True), (2.2, True), (2.0, False)])
def test_a_gap_beside_the_edge_is_chosen_before_a_place_that_touches(side: float, gap_m: float, passes: bool) -> None:
    """A barrier closes the road but for a gap at one edge: 0.1 m are kept to the edge and 0.12 m to the barrier.

    The car is so near to that edge that it gets there.
    """
    edges, barrier = sorted((-12.0 * side, 5.25 * side)), sorted((-12.0 * side, (5.25 - gap_m) * side))
    lane = Lane(2.0 * side, edges[1], edges[0], 0.0, 0.0)
    watch = lateral_cost()
    minimum_m = watch.update(lane, bodies((12.0, barrier[0], barrier[1]))).minimum_m
    free_m = side * minimum_m - (5.25 - gap_m) - 0.5 * CAR.width_m
    assert (free_m > 0.11) == passes
    assert 5.25 - side * minimum_m - 0.5 * CAR.width_m > 0.09
