"""The route on a circle: length and waypoints."""

import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.road import centre_line
from vpf_sim.envs.route import Route

BEND = """
schema = 1
[road]
segments = [{kind = "arc", length_m = 300, radius_m = -100}]
[ego]
s_m = 10.0
lane = 1
[goal]
s_m = 210.0
"""
RADIUS_M = 100.0 + 5.25  # the rightmost lane in a bend to the left


def route() -> Route:
    scenario = scenarios.parse(BEND, "bend.toml")
    return Route.of(centre_line(scenario.road), scenario)


def test_progress_is_the_length_of_the_lane_s_arc() -> None:
    assert route().length_m == pytest.approx(2.0 * RADIUS_M)
    assert route().progress(10.0) == 0.0
    assert route().progress(60.0) == pytest.approx(0.5 * RADIUS_M)


def test_waypoints_lie_on_the_lane_a_metre_apart_from_the_start_to_beyond_the_goal() -> None:
    points, (goal_x, goal_y) = route().waypoints(), route().goal_m
    assert np.hypot(points[:, 0], points[:, 1] + 100.0) == pytest.approx(RADIUS_M)
    chord = 2.0 * RADIUS_M * np.sin(0.5 / RADIUS_M)
    assert np.hypot(*np.diff(points, axis=0).T) == pytest.approx(chord)
    start = RADIUS_M * np.array([np.sin(0.1), np.cos(0.1)]) - [0.0, 100.0]
    assert points[0] == pytest.approx(start)
    assert [goal_x, goal_y] == pytest.approx(RADIUS_M * np.array([np.sin(2.1), np.cos(2.1)]) - [0.0, 100.0])
    assert len(points) - 1 >= 2.0 * RADIUS_M + 30.0
