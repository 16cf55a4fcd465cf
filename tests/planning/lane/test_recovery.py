"""Out of a dead end on the tightest curve, where a shift from the road's direction and back to it is out of reach."""

from collections.abc import Sequence
from dataclasses import replace
from math import hypot, inf, radians, tan

import numpy as np
import pytest
from bicycle import Bicycle
from ideal import Body, Eyes, Road, clearance, perception
from lane_planner import CAR, HALF_M, RECOVERY, ROBUST, SETUP, lane_planner, recovery, unwrap

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.lane.frame import Lane, LaneObstacles, place
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig
from vpf_sim.planning.lane.recovery import Recovery
from vpf_sim.planning.lane.recovery_candidates import STEP_M, Blockers, candidates, separation
from vpf_sim.types import Floats, Obstacles, Reference, RoadEdges

CONFIG = RECOVERY
BEYOND_M, LOCKS = CONFIG.candidates.beyond_m, CONFIG.candidates.locks
NEXT_M, BEGINS_M = unwrap(CONFIG.new_obstacles).beyond_m, unwrap(CONFIG.begin).way_m
LANE = Lane(0.0, 12.0, -12.0, 0.0, 0.0)
FRONT_M = CAR.l_r_m + 0.5 * CAR.length_m  # from the rear axle
DEAD_END = (Body(28.0, 0.0, width_m=3.0), Body(28.0, 2.9))  # no gap to the right edge
CLOSED = (*DEAD_END, Body(28.0, -3.5, width_m=3.0), Body(28.0, -7.0, width_m=3.0))


def drive(
    bodies: Sequence[Body], config: LanePlannerConfig = ROBUST, curvature_per_m: float = 0.0, time_s: float = 40.0
) -> tuple[Bicycle, float, float]:
    """The car, obstacles 3 m before it, from standstill; least clearance m, and largest angle to the road, rad."""
    road, car = Road(curvature_per_m), Bicycle(speed_mps=0.0)
    x, y = road.point(20.0, 0.0)
    car.x_m, car.y_m, car.yaw_rad = float(x), float(y), curvature_per_m * 20.0
    way, hands = lane_planner(SETUP, config), Gtsmc(load_gains("robust"), car.model, 60.0)
    eyes, corners, nearest, turned = Eyes(road, bodies, 16.0), [road.corners(body) for body in bodies], inf, 0.0
    while car.time_s < time_s and road.local(car.x_m, car.y_m)[0] < 40.0:
        _, reference, _ = way.step(perception(road.edges(car), eyes.look(car)), car.observe())
        car.step(hands.command(car.observe(), reference))
        nearest = min(nearest, *(clearance(car, corner) for corner in corners))
        turned = max(turned, abs(car.yaw_rad - curvature_per_m * road.local(car.x_m, car.y_m)[0]))
    return car, nearest, turned


@pytest.mark.parametrize("curvature_per_m", [0.0, 0.01, -0.01])
def test_it_turns_out_where_a_shift_is_out_of_reach(curvature_per_m: float) -> None:
    car, nearest, turned = drive(DEAD_END, curvature_per_m=curvature_per_m)
    assert Road(curvature_per_m).local(car.x_m, car.y_m)[0] >= 40.0
    assert nearest > 0.5 * CONFIG.clearance_m
    assert turned > radians(30.0)


def test_without_it_the_car_stands_for_good() -> None:
    car, nearest, _ = drive(DEAD_END, replace(ROBUST, recovery=None), time_s=20.0)
    assert car.speed_mps < 0.05
    assert car.x_m < 28.0
    assert nearest > 0.5


def test_it_stays_where_all_of_the_road_is_blocked() -> None:
    car, nearest, _ = drive(CLOSED, time_s=12.0)
    assert car.speed_mps < 0.05
    assert car.x_m < 28.0
    assert nearest > 0.5


@pytest.mark.parametrize("curvature_per_m", [0.0, 0.01, -0.01])
def test_the_car_is_turned_as_its_manoeuvre_is(curvature_per_m: float) -> None:
    """At full lock a lag is not made up for, so the manoeuvre counts the way of the axle that it is of."""
    road, car = Road(curvature_per_m), Bicycle(speed_mps=0.0)
    x, y = road.point(20.0, 0.0)
    car.x_m, car.y_m, car.yaw_rad = float(x), float(y), curvature_per_m * 20.0
    way, hands = lane_planner(SETUP, ROBUST), Gtsmc(load_gains("robust"), CAR, 60.0)
    eyes, off = Eyes(road, DEAD_END, 16.0), []
    while car.time_s < 40.0 and road.local(car.x_m, car.y_m)[0] < 40.0:
        _, reference, _ = way.step(perception(road.edges(car), eyes.look(car)), car.observe())
        if way.is_recovering:
            off.append(abs(wrap_angle(reference.heading_rad - car.yaw_rad)))
        car.step(hands.command(car.observe(), reference))
    assert len(off) > 300
    assert max(off) < radians(2.0)


def corner(along_m: Floats, y_m: Floats, turned_rad: Floats, side: float) -> tuple[Floats, Floats]:
    """Of the front, on that side, from poses of the rear axle."""
    cosine, sine = np.cos(turned_rad), np.sin(turned_rad)
    return along_m + FRONT_M * cosine - side * HALF_M * sine, y_m + FRONT_M * sine + side * HALF_M * cosine


@pytest.mark.parametrize("lock", LOCKS)
def test_turning_asks_for_no_more_way_ahead_than_the_circle_does(lock: float) -> None:
    """sqrt((R + b)^2 + a^2) - a with wheels that are turned at once."""
    course = candidates(LANE, 0.0, CAR, per_m=1e3, lock=lock, config=CONFIG.candidates)
    radius = CAR.wheelbase_m / tan(lock * CAR.steering_limit_rad)
    ahead = hypot(radius + HALF_M, FRONT_M) - FRONT_M
    far = np.flatnonzero(np.abs(course.turned_rad).max(axis=1) > radians(75.0))
    for index in far:
        side = -np.sign(course.turned_rad[index][np.abs(course.turned_rad[index]).argmax()])
        turning = slice(0, int(np.abs(course.turned_rad[index]).argmax()))
        along, _ = corner(
            course.along_m[index, turning], course.y_m[index, turning], course.turned_rad[index, turning], side
        )
        assert along.max() - (FRONT_M - CAR.l_r_m) == pytest.approx(ahead, abs=0.06)
    assert len(far) > 10


def test_candidates_keep_the_limits_of_the_steering_and_end_in_the_roads_direction() -> None:
    course = candidates(replace(LANE, heading_rad=0.2), 0.3, CAR, per_m=1.4, lock=1.0, config=CONFIG.candidates)
    assert np.abs(np.diff(course.steering_rad)).max() <= 1.4 * STEP_M + 1e-9
    assert np.abs(course.steering_rad).max() <= CAR.steering_limit_rad + 1e-9
    ended = course.end < course.along_m.shape[1]
    assert ended.mean() > 0.9
    assert np.abs(course.turned_rad[ended, -1]).max() < radians(4.0)
    assert np.hypot(np.diff(course.along_m), np.diff(course.y_m)) == pytest.approx(STEP_M, rel=1e-3)


def test_the_separation_of_rectangles() -> None:
    straight = candidates(LANE, 0.0, CAR, per_m=1e3, lock=1e-9, config=CONFIG.candidates)  # goes on as it is
    beside = LaneObstacles(np.array([4.0]), np.array([1.5]), np.array([2.5]))
    ahead = LaneObstacles(np.array([5.0]), np.array([-0.5]), np.array([0.5]))
    apart, edges = separation(straight, LANE, Blockers.of(beside, 2.0, BEYOND_M), CAR, BEYOND_M)
    assert apart[0, 40] == pytest.approx(1.5 - HALF_M)
    assert edges[0] == pytest.approx(12.0 - HALF_M)
    apart, _ = separation(straight, LANE, Blockers.of(ahead, 1.0, BEYOND_M), CAR, BEYOND_M)
    assert apart[0, 0] == pytest.approx(5.0 - 0.5 * CAR.length_m)
    assert apart[0].min() < 0.0


def reported(speed_mps: float) -> Obstacles:
    """An obstacle of 3 m dead ahead, 3 m before the bumper."""
    one = np.array([5.25]), np.array([-1.5]), np.array([1.5]), np.array([0.1]), np.array([np.inf])
    return Obstacles(*one, identity=np.zeros(1, np.int64), speed_mps=np.array([speed_mps]))


def narrow(forward_m: float, right_m: float, half_m: float, identity: int) -> Obstacles:
    """An obstacle that stands there, vehicle axes."""
    forward, left, right = (np.array([one]) for one in (forward_m, right_m - half_m, right_m + half_m))
    name = np.full(1, identity, np.int64)
    return replace(reported(0.0), forward_m=forward, left_m=left, right_m=right, identity=name)


ON_THE_WAY = narrow(2.3, 0.0, 0.5, 1)


def stood_before(bodies: Obstacles) -> Recovery:
    """After it has stood for so long that it looks for a way."""
    out, car = recovery(), Bicycle(speed_mps=0.0)
    for _ in range(round(60.0 * CONFIG.standing_s) + 2):
        out.update(LANE, bodies, car.observe(), Reference(0.0, 0.0))
    return out


def began() -> Recovery:
    return stood_before(reported(0.0))


def test_before_an_obstacle_that_moves_the_car_waits() -> None:
    assert stood_before(reported(1.0)).manoeuvre is None
    assert began().manoeuvre is not None


def road(y_m: float, heading_rad: float = 0.0) -> RoadEdges:
    """As seen at a place, 24 m wide."""
    return RoadEdges(-12.0 - y_m, 12.0 - y_m, heading_rad, 0.0, 0.02, 1.0, -y_m, 3.5)


def test_on_its_manoeuvre_the_car_knows_the_road_by_its_own_motion() -> None:
    turned = began().lane(road(5.0), Bicycle(3.0, 1.0, 0.8, 0.5).observe())
    assert (turned.y_m, turned.heading_rad) == pytest.approx((1.0, -0.8))


def test_after_it_the_own_lane_is_the_one_it_was() -> None:
    """The road is found again two lanes off, and later where it is."""
    out, car = began(), Bicycle(3.0, 1.0, 0.8, 0.5)
    seen = out.lane(road(1.0, -0.8), car.observe())
    for _ in range(60):
        out.update(seen, ON_THE_WAY, car.observe(), Reference(0.0, 5.0))
    assert out.manoeuvre is None
    along = Bicycle(6.0, -3.0, 0.05, 2.0).observe()
    for y_m in (4.1, 4.2, -2.8, -2.7):
        lane = out.lane(road(y_m, -0.05), along)
        assert lane.y_m == pytest.approx(y_m - 7.0 * (y_m > 0.0))
        assert lane.right_m - lane.y_m == pytest.approx(12.0 - y_m)


@pytest.mark.parametrize(("past_m", "drives"), [(NEXT_M - 0.5, False), (NEXT_M + 0.5, True), (BEYOND_M - 1.0, True)])
def test_what_is_detected_on_the_way_ends_it_no_farther_than_a_little_past_the_manoeuvre(
    past_m: float, drives: bool
) -> None:
    """A narrow obstacle, detected on the manoeuvre, so far before the front of the car at its end."""
    out, car = began(), Bicycle(0.2, 0.0, 0.0, CONFIG.speed_mps)
    course = unwrap(out.manoeuvre)
    end = int(course.end[0])
    front_m, y_m = float(course.along_m[0, end]) + FRONT_M, float(course.y_m[0, end])
    new = narrow(front_m + past_m - car.x_m, y_m, 0.2, 1)
    for _ in range(30):
        out.update(LANE, new, car.observe(), Reference(0.0, 0.0))
    assert (out.manoeuvre is not None) == drives


def test_a_car_that_stands_near_an_obstacle_keeps_the_clearance_from_all_that_follows() -> None:
    """A wide obstacle begins 0.1 m beside the corner, and a narrow one, ahead on the other side, leaves room enough."""
    beside = narrow(0.5 * CAR.length_m, HALF_M + 0.1 + 1.05, 1.05, 0)
    both = beside.concatenate(narrow(4.6, -1.2, 0.3, 1))
    out = stood_before(both)
    course = unwrap(out.manoeuvre)
    bodies = Blockers.of(place(both, LANE, ROBUST.obstacles.parts), ROBUST.obstacles.length_m, BEYOND_M)
    apart, _ = separation(course, LANE, bodies, CAR, BEYOND_M)
    assert apart[0, 0] == pytest.approx(0.1)
    assert apart[0, round(BEGINS_M / STEP_M) :].min() >= CONFIG.clearance_m


def test_a_car_that_is_turned_and_has_no_manoeuvre_stands() -> None:
    """A narrow obstacle is detected on the way, right before the car."""
    out, car = began(), Bicycle(3.0, 1.0, 0.8, 0.5)
    lane = out.lane(road(1.0, -0.8), car.observe())
    for _ in range(60):
        reference = out.update(lane, ON_THE_WAY, car.observe(), Reference(0.0, 5.0))
    assert out.manoeuvre is None
    assert reference is not None
    assert reference.speed_mps == 0.0


TURNED = Bicycle(1.0, 0.1, 0.35, 0.0)


def begun_again(new: Obstacles) -> tuple[Recovery, Lane]:
    """A narrow obstacle ends the manoeuvre; the car stands turned and searches again, with a `new` one detected."""
    out, moves = began(), replace(TURNED, speed_mps=0.5)
    lane = out.lane(road(0.1, -0.35), TURNED.observe())
    for _ in range(30):
        out.update(lane, ON_THE_WAY, moves.observe(), Reference(0.0, 0.0))
    assert out.manoeuvre is None
    for _ in range(round(60.0 * CONFIG.standing_s) + 2):
        out.update(lane, new, TURNED.observe(), Reference(0.0, 0.0))
    return out, lane


def test_what_was_detected_on_a_manoeuvre_is_held_no_farther_against_the_next() -> None:
    """A narrow obstacle, detected before it begins, too far past its end to count on the way."""
    first, lane = begun_again(reported(0.0))
    course = unwrap(first.manoeuvre)
    end = int(course.end[0])
    along = float(course.along_m[0, end]) + FRONT_M + NEXT_M + 0.5
    across = float(course.y_m[0, end]) - lane.y_m
    cosine, sine = np.cos(lane.heading_rad), np.sin(lane.heading_rad)
    new = narrow(cosine * along - sine * across, sine * along + cosine * across, 0.2, 2)
    out, lane = begun_again(new)
    creeps = replace(TURNED, speed_mps=CONFIG.speed_mps)
    for _ in range(30):
        out.update(lane, new, creeps.observe(), Reference(0.0, 0.0))
    assert out.manoeuvre is not None
