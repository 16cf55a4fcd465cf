"""The path across the road that the reference takes: the car can follow it, at walking speed too."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from bicycle import Bicycle
from ideal import Road
from lane_planner import CAR, LIMITS, RATE_HZ, ROBUST, geometry, lane_reference, lateral_path, straight_lane

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.geometry import vehicle_from_world, world_from_vehicle
from vpf_sim.planning.lane.frame import NOTHING, Lane, LaneObstacles, locate
from vpf_sim.planning.lane.kinematic_limits import rear_m
from vpf_sim.types import Floats

LANE = straight_lane(0.0, -12.0, 12.0)


def path(minima_m: Sequence[float], speed_mps: float) -> Floats:
    """(N, 3) place, slope and bend at every step."""
    glide, rows = lateral_path(0.0, 2.0 * speed_mps), []
    for minimum_m in minima_m:
        glide.advance(LANE, minimum_m, np.inf, speed_mps, speed_mps / RATE_HZ)
        rows.append((glide.y_m, glide.slope, glide.bend_per_m))
    return np.array(rows)


@pytest.mark.parametrize("speed_mps", [0.6, 1.2, 2.0, 3.0, 5.55])
@pytest.mark.parametrize("shift_m", [0.5, 1.0, 3.0])
def test_a_shift_keeps_the_limits_of_the_car_and_ends_without_overshoot(speed_mps: float, shift_m: float) -> None:
    y, slope, bend = path([shift_m] * round(30.0 / speed_mps * RATE_HZ), speed_mps).T
    step = speed_mps / RATE_HZ
    assert y[-1] == pytest.approx(shift_m, abs=0.01)
    assert y.max() < 1.03 * shift_m
    assert np.abs(bend).max() <= 1.0 / LIMITS.radius_m + 1e-9
    assert np.abs(bend).max() * speed_mps**2 <= ROBUST.limits.acceleration_mps2 + 1e-9
    assert np.abs(slope).max() <= ROBUST.limits.walking_ratio + 1e-9
    steering = np.abs(np.diff(bend)) / step * speed_mps * CAR.wheelbase_m
    assert steering.max() <= ROBUST.limits.steering_radps + 1e-9


@pytest.mark.parametrize("speed_mps", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("turned_back_after_m", [1.5, 2.5])
def test_a_reversal_overshoots_as_little_as_the_limits_of_the_car_allow(
    speed_mps: float, turned_back_after_m: float
) -> None:
    """The minimum jumps from 4.0 to 0.7 m: from then on the bend falls as fast as it may, until the slope is none."""
    step = speed_mps / RATE_HZ
    before = round(turned_back_after_m / step)
    track = path([4.0] * before + [0.7] * round(15.0 / step), speed_mps)
    y, slope, bend = track[before - 1]
    while slope > 0.0:
        bend = max(bend - float(LIMITS.steering(speed_mps)) * step, -float(LIMITS.tightest(speed_mps)))
        slope += bend * step
        y += slope * step
    assert track[:, 0].max() < max(y, 0.7) + 0.02


def test_a_car_that_stands_goes_along_no_path() -> None:
    glide = lateral_path(0.0, 4.0)
    for _ in range(60):
        glide.advance(LANE, 3.0, np.inf, 1.0, 1.0 / RATE_HZ)
    before = (glide.y_m, glide.slope, glide.bend_per_m)
    for _ in range(600):
        glide.advance(LANE, -3.0, np.inf, 0.0, 0.0)
    assert (glide.y_m, glide.slope, glide.bend_per_m) == before


def test_the_mirrored_minimum_gives_the_mirrored_path() -> None:
    minima = [3.0] * 60 + [-0.5] * 200
    assert np.array_equal(path(minima, 2.0), -path([-minimum for minimum in minima], 2.0))


@pytest.mark.parametrize("speed_mps", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("turned_back_after_m", [1.5, 2.5])
def test_the_car_follows_when_the_minimum_jumps_back(speed_mps: float, turned_back_after_m: float) -> None:
    """On its way to a minimum 4 m aside that jumps to 0.7 m: the path turns back as fast as the car, and no faster."""
    car, hands, road = Bicycle(speed_mps=speed_mps), Gtsmc(load_gains("robust"), CAR, RATE_HZ), Road()
    way = lane_reference(speed_mps)
    off, beside = [], []
    while car.x_m < 18.0:
        lane = locate(road.edges(car))
        minimum_m = 4.0 if car.x_m < turned_back_after_m else 0.7
        reference = way.update(lane, geometry(NOTHING), minimum_m, car.yaw_rad, car.speed_mps)
        off.append(abs(reference.heading_rad - car.yaw_rad))
        beside.append(abs(way.y_m - rear_m(lane, CAR)))
        car.step(hands.command(car.observe(), reference))
    assert max(off) < np.radians(1.5)
    assert max(beside) < 0.06
    assert car.y_m == pytest.approx(0.7, abs=0.05)


@pytest.mark.parametrize("speed_mps", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("first_m", [4.15, -3.0])
def test_the_corners_stay_on_the_carriageway(speed_mps: float, first_m: float) -> None:
    """On the way to the last place beside the right edge, from straight ahead and from having turned away before."""
    car, hands, road = Bicycle(y_m=1.3, speed_mps=speed_mps), Gtsmc(load_gains("robust"), CAR, RATE_HZ), Road()
    way = lane_reference(speed_mps)
    front = []
    edge_m = locate(road.edges(car)).right_m
    while car.x_m < 30.0:
        lane = locate(road.edges(car))
        minimum_m = first_m if 2.0 < car.x_m < 5.0 else edge_m - 1.1
        reference = way.update(lane, geometry(NOTHING), minimum_m, car.yaw_rad, car.speed_mps)
        car.step(hands.command(car.observe(), reference))
        middle = car.y_m + 0.5 * CAR.length_m * np.sin(car.yaw_rad)
        front.append(middle + 0.5 * CAR.width_m * np.cos(car.yaw_rad))
    assert max(front) < edge_m
    assert car.y_m == pytest.approx(edge_m - 1.1, abs=0.1)


@pytest.mark.parametrize("speed_mps", [1.2, 2.0, 3.0])
@pytest.mark.parametrize("way_m", [0.5, 1.5, 2.5, 3.5])
@pytest.mark.parametrize("gap_m", [0.8, 1.2])
def test_the_corners_stay_clear_of_an_obstacle_that_is_passed_next(
    gap_m: float, way_m: float, speed_mps: float
) -> None:
    """An obstacle stands to the right, farther than the car shall go: it gets there turned, its corner first."""
    car, hands, road = Bicycle(speed_mps=speed_mps), Gtsmc(load_gains("robust"), CAR, RATE_HZ), Road()
    way, front = lane_reference(speed_mps), []
    half_length, half_width = 0.5 * CAR.length_m, 0.5 * CAR.width_m
    face_m, side_m = way_m + half_length, gap_m + half_width
    while car.x_m < face_m + 4.0:
        body = LaneObstacles(np.array([face_m - car.x_m]), np.array([side_m]), np.array([side_m + 2.0]))
        reference = way.update(locate(road.edges(car)), geometry(body), gap_m - 0.15, car.yaw_rad, car.speed_mps)
        car.step(hands.command(car.observe(), replace(reference, speed_mps=speed_mps)))
        ahead = car.x_m + half_length * np.cos(car.yaw_rad) - half_width * np.sin(car.yaw_rad)
        aside = car.y_m + half_length * np.sin(car.yaw_rad) + half_width * np.cos(car.yaw_rad)
        front.append(side_m - aside if ahead > face_m else side_m)
    assert min(front) > 0.05


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("gap_m", [0.03, 0.06])
@pytest.mark.parametrize("shift_m", [1.2, 1.5])
def test_a_car_that_is_turned_from_an_obstacle_beside_the_car_turns_back_behind_it(
    shift_m: float, gap_m: float, side: float
) -> None:
    """A corner is beside the bumper, and the edge ahead asks for turning back: the side would swing."""
    car, hands, road = Bicycle(speed_mps=3.0), Gtsmc(load_gains("robust"), CAR, RATE_HZ), Road()
    way, gaps = lane_reference(3.0), [gap_m]

    def drive(lane: Lane, bodies: LaneObstacles, minimum_m: float) -> None:
        reference = way.update(lane, geometry(bodies), minimum_m, car.yaw_rad, car.speed_mps)
        car.step(hands.command(car.observe(), replace(reference, speed_mps=3.0)))

    while side * car.yaw_rate_radps <= 0.0:  # until it is turned most
        drive(locate(road.edges(car)), NOTHING, -shift_m * side)
    corner = np.array([0.5 * CAR.length_m - 0.1, side * (0.5 * CAR.width_m + gap_m)])
    face_m, side_m = world_from_vehicle(corner, np.array([car.x_m, car.y_m, car.yaw_rad]))
    edge_m = CAR.l_r_m * abs(np.sin(car.yaw_rad)) - side * car.y_m + 0.5 * CAR.width_m + 1.3
    left_m, right_m = sorted((side_m, side_m + side))
    while car.x_m < face_m + 2.0:
        lane = replace(locate(road.edges(car)), left_m=-edge_m, right_m=edge_m)
        body = LaneObstacles(np.array([face_m - car.x_m]), np.array([left_m]), np.array([right_m]))
        drive(lane, body, side * (1.4 - edge_m))
        ahead, aside = vehicle_from_world(np.array([face_m, side_m]), np.array([car.x_m, car.y_m, car.yaw_rad]))
        if ahead > -CAR.l_r_m:
            gaps.append(side * aside - 0.5 * CAR.width_m)
        front_m = car.y_m + 0.5 * CAR.length_m * np.sin(car.yaw_rad)
        assert edge_m + side * front_m - 0.5 * CAR.width_m * np.cos(car.yaw_rad) > -0.1  # 0.2 m is a departure
    assert min(gaps) > gap_m - 0.015


@pytest.mark.parametrize(("way_m", "gap_m", "leaves"), [(6.0, 1.9, False), (12.0, 1.9, True), (6.0, 2.3, True)])
def test_near_a_gap_that_is_too_narrow_the_car_is_not_turned_towards_it(
    way_m: float, gap_m: float, leaves: bool
) -> None:
    """A row closes the road but for a gap 1 m to the right: it can still stop, and the gap may be none."""
    faces, half = np.full(2, way_m + 0.5 * CAR.length_m), 0.5 * gap_m
    bodies = LaneObstacles(faces, np.array([-12.0, 1.0 + half]), np.array([1.0 - half, 12.0]))
    way = lane_reference(1.5)
    for _ in range(150):
        way.update(LANE, geometry(bodies), 1.0, 0.0, 1.5)
    assert (way.y_m > 0.1) == leaves


@pytest.mark.parametrize(("way_m", "right_m", "leaves"), [(16.0, 12.0, False), (9.0, 12.0, True), (16.0, 2.6, True)])
def test_the_own_lane_is_left_no_sooner_than_it_must_be(way_m: float, right_m: float, leaves: bool) -> None:
    """1.5 m aside before an obstacle, at 5.55 m/s; at once where another obstacle leaves no room to spare."""
    half = 0.5 * CAR.width_m
    faces = np.full(2, way_m + 0.5 * CAR.length_m)
    bodies = LaneObstacles(faces, np.array([-1.0, right_m]), np.array([1.5 - half - 0.43, right_m + 1.0]))
    way = lane_reference()
    for _ in range(5):
        way.update(LANE, geometry(bodies), 1.5, 0.0, 5.55)
    assert (way.y_m > 0.0) == leaves


@pytest.mark.parametrize(("speed_mps", "leaves"), [(0.0, False), (3.0, True)])
def test_a_slower_car_is_not_waited_for(speed_mps: float, leaves: bool) -> None:
    """Who is still behind it when it is near is no longer let past."""
    half = 0.5 * CAR.width_m
    ahead = LaneObstacles(
        np.array([16.0 + 0.5 * CAR.length_m]), np.array([-1.0]), np.array([1.5 - half - 0.43]), np.array([speed_mps])
    )
    way = lane_reference()
    for _ in range(5):
        way.update(LANE, geometry(ahead), 1.5, 0.0, 5.55)
    assert (way.y_m > 0.0) == leaves


def test_between_two_obstacles_the_path_is_that_of_the_mirrored_world() -> None:
    """Where no slope is free to either side, it is neither's."""

    def ended(side: float) -> float:
        glide, edges = lateral_path(0.1 * side, 4.0), sorted((-0.9 * side, 1.0 * side))
        for _ in range(60):
            glide.advance(replace(LANE, left_m=edges[0], right_m=edges[1]), 0.0, np.inf, 2.0, 2.0 / RATE_HZ)
        return glide.y_m

    assert ended(1.0) == -ended(-1.0)


def test_the_way_back_does_not_wait() -> None:
    """A car 1.5 m aside, its lane free, and an obstacle beside its present way far ahead."""
    body = LaneObstacles(np.array([14.0]), np.array([1.0]), np.array([3.0]))
    way = lane_reference()
    for _ in range(30):
        way.update(replace(LANE, y_m=1.5), geometry(body), 0.0, 0.0, 5.55)
    assert way.y_m < 1.45
