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
    SPEED_MPS,
    geometry,
    lane_reference,
    lateral_cost,
    straight_lane,
)

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.driver_interface import Command
from vpf_sim.planning.lane.frame import NOTHING, Lane, LaneObstacles, locate, place
from vpf_sim.planning.lane.lateral_cost import LateralCost
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.types import Obstacles, RoadEdges

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


def test_an_obstacle_that_leaves_no_way_before_it_is_not_crossed() -> None:
    """Beyond an obstacle lies the only free way; from far away it is chosen, from near by no longer."""
    barrier, closes = (-0.5, 1.5), (-8.75, -0.4)

    def minimum(way_m: float) -> float:
        lane = replace(LANE, y_m=-1.7)
        return field(lane).update(lane, bodies((way_m + 2.25, *barrier), (way_m + 3.25, *closes))).minimum_m

    assert minimum(12.0) > 1.5 + 0.5 * CAR.width_m
    assert minimum(3.0) < 1.5
    assert minimum(-1.0) < -0.5


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
    reach = float(LIMITS.largest_shift(np.array([way_m]))[0])
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
    assert LIMITS.heading_shift(np.array([way_m]), slope)[0] == pytest.approx(at_face + side)


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


def seen(*rows: tuple[float, float, float, int]) -> LaneObstacles:
    """What the lane has of obstacles by face, left, right, identity."""
    forward, left, right, identity = np.array(rows).T
    unknown = np.full(len(rows), 0.1)
    road = RoadEdges(-8.75, 5.25, 0.0, 0.0, 0.02, 1.0, 0.0, 3.5)
    return place(
        Obstacles(forward, left, right, unknown, unknown, identity.astype(np.int64)),
        locate(road),
        ROBUST.obstacles.parts,
    )


def test_a_part_of_an_obstacle_is_no_obstacle_of_its_own() -> None:
    """An edge low on its side, or points that fell away from its others; not what stands beside or far behind it."""
    car = (10.0, 0.0, 2.0, 1)
    assert len(seen(car, (14.0, -0.2, 0.4, 2))) == 1
    assert len(seen(car, (13.0, -0.5, 0.1, 1))) == 1
    assert len(seen(car, (13.0, -1.5, 0.1, 1))) == 2
    assert len(seen(car, (13.0, -0.5, 0.1, 2))) == 2
    assert len(seen(car, (10.3, 0.2, 0.8, 2))) == 2
    assert len(seen(car, (20.0, 0.2, 0.8, 2))) == 2
    assert seen((14.0, -0.2, 0.4, 2), car).along_m.tolist() == [10.0]
    assert len(seen((10.0, 0.3, 1.5, 1), (15.5, 0.0, 1.8, 2))) == 2, "a car behind a pallet"


def test_where_no_place_is_free_it_keeps_clear_of_what_is_too_near_for_a_stop() -> None:
    """A wall on the left, a car near on the right, in the gap between, farther on, a pallet for which it can stop."""
    near, pallet, wall = (4.5, 1.4, 5.3), (6.5, -1.0, -0.2), (6.5, -8.8, -1.4)
    lane = replace(LANE, right_m=5.25, left_m=-8.75)
    at_once = field(lane).update(lane, bodies(near, pallet, wall), speed_mps=4.5).minimum_m
    standing = field(lane).update(lane, bodies(near, pallet, wall), speed_mps=0.0).minimum_m
    assert standing > 0.5, "least of all is overlapped between pallet and car"
    assert at_once < 1.4 - 0.5 * CAR.width_m, "clear of the car"


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


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_gap_beside_the_edge_is_not_chosen_from_too_near(side: float) -> None:
    """A row leaves 2.6 m at one edge and, on the other side, 4 m; the edge lets the car come near but slowly.

    The narrow gap was chosen before the row was known, and is kept to while the shift is in reach at all.
    """
    edges = sorted((-12.0 * side, 5.25 * side))
    row = [sorted((a * side, b * side)) for a, b in ((-2.2, 2.65), (-12.0, -6.2))]

    def chosen(way_m: float) -> float:
        lane = Lane(0.0, edges[1], edges[0], 0.0, 0.0)
        one = field(lane)
        one.keep(side * 4.0)
        face_m = way_m + 0.5 * CAR.length_m
        return side * one.update(lane, bodies(*((face_m, *body) for body in row))).minimum_m

    assert chosen(10.8) > 2.65 + 0.5 * CAR.width_m
    assert chosen(8.5) < -2.2 - 0.5 * CAR.width_m


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_gap_that_the_edge_keeps_the_car_from_is_not_chosen_though_its_side_was(side: float) -> None:
    """A row 10 m ahead closes the gap between two obstacles that was meant, and leaves 2.5 m at the edge, or 4 m.

    With the edge farther off on that side as much is free beside the row, and the side is kept.
    """
    row = [sorted((a * side, b * side)) for a, b in ((-2.2, 2.75), (-12.0, -6.2))]

    def chosen(edge_m: float) -> float:
        edges = sorted((-12.0 * side, edge_m * side))
        lane = Lane(0.0, edges[1], edges[0], 0.0, 0.0)
        one = field(lane)
        one.keep(side * 0.6)
        return side * one.update(lane, bodies(*((10.0 + 0.5 * CAR.length_m, *body) for body in row))).minimum_m

    assert chosen(5.25) < -2.2 - 0.5 * CAR.width_m
    assert chosen(7.0) > 2.75 + 0.5 * CAR.width_m


@pytest.mark.parametrize("way_m", [10.2, 10.5, 10.8])
def test_a_gap_beside_the_edge_that_is_chosen_is_gone_through(way_m: float) -> None:
    """The same row, in a closed loop from 5.55 m/s: what has been begun is not given up halfway."""
    row, car, past = [(-2.2, 2.65), (-12.0, -6.2)], Bicycle(speed_mps=SPEED_MPS), way_m + CAR.length_m + 2.0
    one, hands = field(replace(LANE, left_m=-12.0)), Gtsmc(load_gains("robust"), CAR, 60.0)
    path = lane_reference()
    one.keep(4.0)
    while car.x_m < past and car.time_s < 15.0:
        lane = Lane(car.y_m, 5.25, -12.0, -car.yaw_rad, 0.0)
        ahead = bodies(*((way_m + 0.5 * CAR.length_m - car.x_m, *body) for body in row))
        minimum_m = one.update(lane, ahead, car.speed_mps).minimum_m
        reference = path.update(lane, ahead, minimum_m, car.yaw_rad, car.speed_mps)
        car.step(hands.command(car.observe(), reference))
    assert car.x_m >= past
    assert car.y_m > 2.65 + 0.5 * CAR.width_m


@pytest.mark.parametrize(("gap_m", "slope"), [(6.0, 0.0), (4.3, 0.0), (4.3, 0.2), (4.3, -0.3), (1.5, 0.05)])
def test_the_way_to_an_edge_is_that_of_the_law_by_which_the_path_comes_near(gap_m: float, slope: float) -> None:
    """Integrated: turning on the tightest curve, then g' = -g / arm, until the rear axle is beside the face."""
    left_m, step_m = np.array([0.3, 0.8, 1.2]), 1e-3
    told = LIMITS.edge_way(gap_m, left_m, slope)
    gap, way, reached = gap_m, -0.5 * CAR.length_m - CAR.l_r_m, np.full(3, np.inf)
    while gap > left_m[0]:
        slope = min(slope + step_m / LIMITS.radius_m, ROBUST.limits.walking_ratio, gap / LIMITS.path_arm_m)
        gap, way = gap - slope * step_m, way + step_m
        reached = np.where((gap <= left_m) & (reached == np.inf), way, reached)
    assert told == pytest.approx(reached, abs=0.3)
    assert LIMITS.edge_way(0.0, left_m, slope).tolist() == [-np.inf] * 3
    assert LIMITS.edge_way(gap_m, np.array([-0.1, gap_m + 0.1]), slope).tolist() == [np.inf, -np.inf]


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_car_that_has_turned_to_one_side_of_an_obstacle_keeps_to_it_though_the_obstacle_is_detected_wider(
    side: float,
) -> None:
    """12 m ahead, farther away than sides are kept to otherwise: the part seen first lies on the other side."""
    edges = sorted((-8.75 * side, 8.75 * side))

    def kept(heading_rad: float) -> float:
        lane = Lane(0.3 * side, edges[1], edges[0], -side * heading_rad, 0.0)
        one = field(replace(lane, heading_rad=0.0))
        for far_side_m in (0.5, 1.6):
            row = bodies((12.0 + 0.5 * CAR.length_m, *sorted((-side * 0.8, side * far_side_m))))
            minimum = one.update(lane, row).minimum_m
        return side * minimum

    assert kept(0.1) > 1.6
    assert kept(0.0) < -0.8
    assert kept(-0.1) < -0.8, "turned to the other side"


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("last_m", "keeps"), [(0.3, False), (0.7, False), (1.3, True)])
def test_an_obstacle_that_is_detected_where_the_car_was_going_has_no_side_yet(
    side: float, last_m: float, keeps: bool
) -> None:
    """10 m ahead, its middle .1 m off: the shorter way leads past its other side; it is 1.3 m to be clear on this."""
    one = field(Lane(0.0, 8.75, -8.75, 0.0, 0.0))
    one.keep(side * last_m)
    row = bodies((10.0 + 0.5 * CAR.length_m, *sorted((-0.1 * side, 0.3 * side))))
    assert (side * one.update(Lane(0.0, 8.75, -8.75, 0.0, 0.0), row).minimum_m > 0.0) == keeps


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("gap_m", "heading_rad", "leaves"), [(3.2, 0.0, True), (4.5, 0.0, False), (3.2, 0.1, False)])
def test_a_gap_that_proves_narrow_is_left_for_a_free_side(
    side: float, gap_m: float, heading_rad: float, leaves: bool
) -> None:
    """A cone is to be passed on the side with more road, where 10 m ahead an obstacle is detected beside it.

    Through a wide gap the car goes all the same, and who has turned to it through any that is wide enough.
    """
    lane = Lane(0.0, 8.0 + side, -8.0 + side, 0.0, 0.0)
    one, inner_m, outer_m = field(lane), 0.1 * side, (0.1 + gap_m) * side
    cone = sorted((-0.4 * side, inner_m))
    assert side * one.update(lane, bodies((14.5, *cone))).minimum_m > 0.0
    row = bodies((12.5, *cone), (12.6, *sorted((outer_m, outer_m + side))))
    minimum = one.update(replace(lane, heading_rad=-side * heading_rad), row).minimum_m
    assert (side * minimum < 0.0) == leaves


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("face_m", "width_m", "leaves"), [(12.0, 2.5, True), (12.0, 2.0, False), (22.0, 2.5, False)])
def test_a_pedestrian_beside_a_truck_is_of_its_row_though_his_face_is_farther(
    side: float, face_m: float, width_m: float, leaves: bool
) -> None:
    """He stands 7 m behind its face, where a car has ended: farther off than obstacles count otherwise. Between them it
    is narrow, on the other side of the truck is more room. From far off neither is near enough for a choice."""
    lane = Lane(0.0, 8.75, -8.75, 0.0, 0.0)
    truck, person = ((a * side, b * side) for a, b in ((-0.5 - width_m, -0.5), (2.9, 3.4)))
    along_m = face_m + 0.5 * CAR.length_m
    minimum = field(lane).update(lane, bodies((along_m, *sorted(truck)), (along_m + 7.0, *sorted(person)))).minimum_m
    assert (side * minimum < -3.0) == leaves
