"""Gaps between rectangles against the exact distance, and what is priced."""

from math import hypot, pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from made_scene import road, scene, tracks

from vpf_sim.envs.contacts import distance
from vpf_sim.planning.spacetime import settings
from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.planning.spacetime.motions import motions
from vpf_sim.planning.spacetime.obstacles import ObstaclePotential, turning_gap_m
from vpf_sim.planning.spacetime.rectangles import Gaps, Rectangles, gaps, nearness_m, way_ahead
from vpf_sim.scene import predict
from vpf_sim.types import VehicleModel

COORDINATE = st.floats(-8.0, 8.0)
ANGLE = st.floats(-3.1, 3.1)
NOW = np.array([0.0])


def rectangle(x_m: float, y_m: float, heading_rad: float, length_m: float, width_m: float) -> SimpleNamespace:
    return SimpleNamespace(position=np.array([x_m, y_m]), heading=heading_rad, LENGTH=length_m, WIDTH=width_m)


def gaps_to(
    place: tuple[float, float, float], size: tuple[float, float], quantile: float = 0.0, sigma: float = 0.0
) -> Gaps:
    """Of the object at a place to a car of 4.5 x 1.9 m at the origin."""
    made = tracks(road(), (*place, 0.0, *size))
    made.covariance[0, 0, 0] = sigma**2
    at_origin = np.zeros((1, 1), np.float32)
    car = Rectangles.of_car([at_origin] * 3, VehicleModel())
    return gaps(car, Rectangles.of_tracks(predict(road(), made, NOW), (0.0, 0.0), quantile))


def largest_gap(*arguments: Any) -> float:
    return float(gaps_to(*arguments).largest[0, 0])


@given(COORDINATE, COORDINATE, ANGLE, st.floats(0.3, 6.0), st.floats(0.3, 3.0))
def test_rectangles_overlap_where_no_axis_parts_them(
    x_m: float, y_m: float, heading_rad: float, length_m: float, width_m: float
) -> None:
    exact_m = distance(rectangle(0.0, 0.0, 0.0, 4.5, 1.9), rectangle(x_m, y_m, heading_rad, length_m, width_m))
    gap_m = largest_gap((x_m, y_m, heading_rad), (length_m, width_m))
    assert gap_m <= exact_m + 1e-4  # an axis shows at most the distance
    if abs(gap_m) > 1e-4:
        assert (gap_m < 0.0) == (exact_m == 0.0)


@pytest.mark.parametrize("quantile", [1.0, 2.0])
def test_an_uncertain_object_is_longer(quantile: float) -> None:
    assert largest_gap((10.0, 0.0, 0.0), (4.0, 2.0), quantile, 0.5) == pytest.approx(10.0 - 2.25 - 2.0 - 0.5 * quantile)


@given(st.floats(3.0, 9.0), st.floats(-4.0, 4.0), ANGLE, st.floats(0.3, 6.0), st.floats(0.3, 3.0))
def test_the_way_ahead_is_driven_without_contact_and_ends_at_the_object(
    x_m: float, y_m: float, heading_rad: float, length_m: float, width_m: float
) -> None:
    other = rectangle(x_m, y_m, heading_rad, length_m, width_m)
    assume(distance(rectangle(0.0, 0.0, 0.0, 4.5, 1.9), other) > 0.1)
    ahead_m = float(way_ahead(gaps_to((x_m, y_m, heading_rad), (length_m, width_m)), 0.0)[0, 0])
    driven = np.arange(0.0, 15.0, 0.1)
    slim = 4.5 - 2e-3, 1.9 - 2e-3  # sides that touch are no contact
    is_met = np.array([distance(rectangle(float(x), 0.0, 0.0, *slim), other) == 0.0 for x in driven])
    before, beyond = driven < ahead_m - 1e-3, (driven > ahead_m + 1e-3) & (driven < ahead_m + 0.15)
    assert not is_met[before].any()
    if np.isfinite(ahead_m) and y_m**2 < 0.2:  # where it drives into it, and does not touch a corner only
        assert is_met[beyond].any()


@pytest.mark.parametrize("turned_rad", [pi / 4.0, -pi / 4.0])
def test_a_turned_object_is_met_at_its_own_side(turned_rad: float) -> None:
    """A thin door of 4 m, whose middle is on the car's line: the car meets it with a corner, before its middle."""
    ahead_m = float(way_ahead(gaps_to((8.0, 0.0, turned_rad), (4.0, 0.01)), 0.0)[0, 0])
    assert ahead_m == pytest.approx(8.0 - 2.25 - 0.95, abs=0.02)  # at 45 deg it is as much nearer as it is aside
    assert float(gaps_to((8.0, 0.0, turned_rad), (4.0, 0.01)).along[0, 0]) < ahead_m - 0.4


@pytest.mark.parametrize("heading_rad", [0.0, 0.6, 1.2, 2.5])
def test_a_long_wall_is_as_near_as_it_is_across_whatever_its_angle(heading_rad: float) -> None:
    """The nearest point of a wall that turns away from the car is where lengths along the heading count less."""
    wall = gaps_to(
        (0.0, 0.95 + 1.0 + 0.5 * abs(np.cos(heading_rad)) + 3.0 * abs(np.sin(heading_rad)), heading_rad), (6.0, 1.0)
    )
    assert float(nearness_m(wall)[0, 0]) == pytest.approx(1.0, abs=1e-4)


def test_the_turning_gap_is_what_a_circle_on_full_lock_needs() -> None:
    """The car's outer front corner is followed once around the circle's middle, in small steps."""
    vehicle, curvature = VehicleModel(), 0.28
    x, y, yaw, farthest_m, step_m = 0.0, 0.0, 0.0, 0.0, 0.001
    slip = np.arctan(vehicle.l_r_m * curvature)
    for _ in range(6000):
        x, y = x + step_m * np.cos(yaw + slip), y + step_m * np.sin(yaw + slip)
        yaw += step_m * np.sin(slip) / vehicle.l_r_m
        corner = hypot(0.5 * vehicle.length_m, 0.5 * vehicle.width_m)
        angle = yaw - np.arctan2(vehicle.width_m, vehicle.length_m)
        farthest_m = max(farthest_m, x + corner * np.cos(angle))
    assert turning_gap_m(vehicle, curvature) == pytest.approx(farthest_m - 0.5 * vehicle.length_m, abs=0.01)


def costs_beside(
    gap_m: float, ahead_m: float = 5.0, speed_mps: float = 5.0, other_mps: float = 0.0
) -> tuple[float, float]:
    """Price of contacts, and cost of nearness and distance, of a car that drives past another one for five seconds."""
    on, planner = road(), settings.load()
    start, times = PathState(0.0, 0.0, 0.0, 0.0, speed_mps, 0.0), np.arange(0.0, 5.1, 0.2)
    path = Paths(np.zeros(1), np.ones(1), np.zeros((1, 6)))
    speeds = np.full((1, len(times)), speed_mps)
    driven = motions(on, start, path, Profiles(speeds * times, speeds, 0.0 * speeds), VehicleModel())
    now = scene(on, tracks(on, (ahead_m, 1.9 + gap_m, 0.0, other_mps, 4.5, 1.9)), speed_mps=speed_mps)
    prediction = predict(on, now.tracks, times)
    objects = ObstaclePotential(planner.limits, planner.cost, prediction, times, VehicleModel(), now, driven.origin_m)
    price, near = objects.of(driven, np.array([0]))
    return float(price[0]), float(near[0])


def assert_falls_steadily(costs: np.ndarray) -> None:
    """To 0, without a jump: each time by little more than the time before."""
    assert costs[0] > 0.3
    assert costs[-1] == 0.0
    falls = -np.diff(costs)
    assert (falls >= -1e-6).all()
    assert (falls[1:] < 1.5 * falls[:-1] + 1e-3 * costs[0]).all()


def test_the_cost_of_an_object_beside_falls_steadily_to_nothing() -> None:
    assert_falls_steadily(np.array([costs_beside(gap_m)[1] for gap_m in np.arange(0.3, 4.0, 0.02)]))


@pytest.mark.parametrize("speed_mps", [2.0, 5.0, 15.0])
def test_the_cost_of_an_object_ahead_falls_steadily_to_nothing(speed_mps: float) -> None:
    """Of one that drives as fast, from 2 m before the car on."""
    away_m = 4.5 + np.arange(2.0, 25.0, 0.05)
    assert_falls_steadily(np.array([costs_beside(-1.9, ahead_m, speed_mps, speed_mps)[1] for ahead_m in away_m]))


def test_an_object_that_is_reached_late_is_met() -> None:
    assert costs_beside(-1.9, 60.0, 15.0)[0] > 0.0
