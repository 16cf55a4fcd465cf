"""Robust planning and control in a closed loop with ideal perception: what must hold before any camera comes in."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, radians

import numpy as np
import pytest
from bicycle import Bicycle
from ideal import Body, Eyes, Road, clearance, perception
from lane_planner import CLEARANCE, ROBUST, lane_planner

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.driver_interface import DriverSetup
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

KEPT_M = CLEARANCE.wanted_m - 0.1  # of the requested clearance


@dataclass
class Run:
    """What happened, a value a step: s, lateral m, speed m/s, lateral acceleration m/s2, steering rad."""

    track: Floats  # (5, n)
    clearance_m: float


def drive(
    road: Road,
    bodies: Sequence[Body] = (),
    length_m: float = 150.0,
    start_m: float = 0.0,
    range_m: float = 16.0,
    noise_deg: float = 0.0,
    delay_frames: int = 0,
    rate_hz: float = 60.0,
    time_s: float = 60.0,
) -> Run:
    x, y = road.point(0.0, start_m)
    car = Bicycle(float(x), float(y), rate_hz=rate_hz)
    setup = DriverSetup(Camera(), car.model, rate_hz, 5.55, (1e3, 0.0), 0)
    way, hands = lane_planner(setup, ROBUST), Gtsmc(load_gains("robust"), car.model, rate_hz)
    eyes, corners = Eyes(road, bodies, range_m), [road.corners(body) for body in bodies]
    random, seen = stream(0, "ideal perception"), deque(maxlen=delay_frames + 1)
    rows, nearest = [], inf
    for _ in range(int(time_s * rate_hz)):
        s, lateral = road.local(car.x_m, car.y_m)
        if s > length_m:
            break
        edges = road.edges(car, radians(noise_deg) * float(random.standard_normal()))
        seen.append((perception(edges, eyes.look(car)), car.observe()))
        view, observation = seen[0]
        _, reference, _ = way.step(view, observation)
        car.step(hands.command(observation, reference))
        rows.append((s, lateral, car.speed_mps, car.speed_mps * car.yaw_rate_radps, car.steering_rad))
        nearest = min([nearest, *(clearance(car, corner) for corner in corners)])
    return Run(np.array(rows).T, nearest)


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.01])
def test_it_stays_on_the_lane(curvature: float) -> None:
    track = drive(Road(curvature), start_m=0.3, length_m=120.0).track
    assert np.mean(track[1] ** 2) <= 0.01
    assert np.abs(track[1, track[0] > 40.0]).max() < 0.05
    assert np.abs(track[3]).max() < 1.0
    assert np.all(np.abs(track[2] - 5.55) < 0.02)


@pytest.mark.parametrize(("hidden_s", "slowest_mps"), [(5, 1.0), (20, 0.0)])
def test_a_car_that_does_not_see_the_road_creeps_on_then_stands_until_it_does(
    hidden_s: int, slowest_mps: float
) -> None:
    road, car = Road(), Bicycle()
    setup = DriverSetup(Camera(), car.model, 60.0, 5.55, (1e3, 0.0), 0)
    way, hands, nothing = (
        lane_planner(setup, ROBUST),
        Gtsmc(load_gains("robust"), car.model, 60.0),
        Eyes(road, (), 16.0),
    )
    speeds = []
    for step in range(60 * (hidden_s + 8)):
        edges = replace(road.edges(car), confidence=0.0 if 60 <= step < 60 * (hidden_s + 1) else 1.0)
        view = perception(edges, nothing.look(car))
        _, reference, _ = way.step(view, car.observe())
        car.step(hands.command(car.observe(), reference))
        speeds.append(car.speed_mps)
    assert speeds[59] == pytest.approx(5.55, abs=0.02)
    assert np.diff(speeds).min() > -4.05 / 60.0  # nuPlan's bound of comfort
    assert speeds[60 * (hidden_s + 1) - 1] == pytest.approx(slowest_mps, abs=0.1)
    assert speeds[-1] == pytest.approx(5.55, abs=0.05)


TOWN = (Body(35.3, -2.09), Body(119.3, 0.91))  # the paper's two obstacles, on a bend as there


@pytest.mark.parametrize("range_m", [12.0, 20.0])
def test_it_passes_the_papers_obstacles(range_m: float) -> None:
    run = drive(Road(1.0 / 186.6), TOWN, 192.0, 0.1, range_m, noise_deg=0.3, delay_frames=2)
    lateral = run.track[1]
    assert run.clearance_m >= KEPT_M
    assert np.mean(lateral**2) <= 0.40
    assert np.abs(run.track[3]).max() < 3.0
    assert lateral.min() > -2.2
    assert run.track[2].min() > 3.0
    rate = 60.0 * np.abs(np.diff(run.track[4]))
    assert np.percentile(rate, 95) < 0.7


def test_it_takes_a_slalom_at_20_frames_a_second() -> None:
    bodies = [Body(50.0 * row, 1.2 * (-1) ** row) for row in (1, 2, 3)]
    run = drive(Road(), bodies, 190.0, noise_deg=0.3, delay_frames=1, rate_hz=20.0)
    assert run.track[0, -1] > 189.0
    assert run.clearance_m >= KEPT_M
    assert np.abs(run.track[3]).max() < 3.0


def test_an_obstacle_dead_ahead_is_passed_on_the_side_with_more_road() -> None:
    run = drive(Road(), [Body(60.0, 0.0)], 110.0)
    assert run.clearance_m >= KEPT_M
    assert run.track[1].min() < -2.0
    assert run.track[1].max() < 0.3


def test_it_stops_before_a_blocked_road() -> None:
    wall = [Body(60.0, lateral, width_m=3.4) for lateral in (-7.0, -3.5, 0.0, 3.5)]
    run = drive(Road(), wall, 110.0, time_s=25.0)
    assert run.track[2, -1] < 0.05
    assert 1.0 < run.clearance_m < 15.0
