"""The path across the road that the reference takes: the car can follow it, at walking speed too."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from bicycle import Bicycle
from ideal import Road
from lane_planner import CAR, LIMITS, RATE_HZ, ROBUST, geometry, lane_reference, lateral_path, straight_lane

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.planning.lane.frame import NOTHING, locate
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


def test_between_two_obstacles_the_path_is_that_of_the_mirrored_world() -> None:
    """Where no slope is free to either side, it is neither's."""

    def ended(side: float) -> float:
        glide, edges = lateral_path(0.1 * side, 4.0), sorted((-0.9 * side, 1.0 * side))
        for _ in range(60):
            glide.advance(replace(LANE, left_m=edges[0], right_m=edges[1]), 0.0, np.inf, 2.0, 2.0 / RATE_HZ)
        return glide.y_m

    assert ended(1.0) == -ended(-1.0)
