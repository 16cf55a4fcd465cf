"""Nearest points and look-ahead points on straights and circles, in closed form."""

from math import asin, cos, pi, sin

import numpy as np
import pytest

from vpf_sim.controllers.polyline import Polyline
from vpf_sim.geometry import unwrapped
from vpf_sim.types import Floats


def circle(radius_m: float, spacing_m: float, turn_rad: float = pi) -> Floats:
    """Waypoints from the origin along X, bending right for radius > 0."""
    angle = np.arange(0.0, turn_rad * abs(radius_m), spacing_m) / radius_m
    return np.stack([radius_m * np.sin(angle), radius_m * (1.0 - np.cos(angle))], axis=1)


STRAIGHT = np.column_stack([np.arange(60.0), np.zeros(60)])


@pytest.mark.parametrize("side_m", [-1.5, 0.0, 0.7])
def test_beside_a_straight(side_m: float) -> None:
    line = Polyline(STRAIGHT)
    for x in np.arange(0.0, 58.0, 0.37):
        assert line.nearest(float(x), side_m) == pytest.approx((side_m, 0.0))


@pytest.mark.parametrize("radius_m", [50.0, -50.0])
def test_beside_a_circle(radius_m: float) -> None:
    """Between waypoints of spacing d the chord lies d^2 / 8R inside the arc."""
    line = Polyline(circle(radius_m, 1.0))
    for angle in np.arange(0.05, 3.0, 0.013):
        turn = angle if radius_m > 0.0 else -angle
        right_m = 0.4
        x, y = (radius_m - right_m) * sin(turn), radius_m - (radius_m - right_m) * cos(turn)
        foot = line.nearest(x, y)
        assert foot.right_m == pytest.approx(right_m, abs=1.0 / (8.0 * 50.0) + 1e-6)
        assert foot.heading_rad == pytest.approx(turn, abs=1e-4)


def test_heading_is_continuous_through_half_a_turn() -> None:
    line = Polyline(-circle(30.0, 1.0, 2.0))  # sets out against X
    headings = [line.nearest(-30.0 * sin(a), -30.0 * (1.0 - cos(a))).heading_rad for a in np.arange(0.1, 1.9, 0.01)]
    assert np.max(np.abs(np.diff(unwrapped(headings)))) < 0.011
    assert -pi <= min(headings) <= max(headings) < pi


@pytest.mark.parametrize("radius_m", [40.0, -40.0])
def test_the_point_ahead_is_where_the_line_leaves_the_circle_of_the_reach(radius_m: float) -> None:
    line = Polyline(circle(radius_m, 0.05))
    for angle in np.arange(0.1, 2.5, 0.1):
        turn = float(np.copysign(angle, radius_m))
        x, y = radius_m * sin(turn), radius_m * (1.0 - cos(turn))
        further = turn + float(np.copysign(2.0 * asin(6.0 / (2.0 * 40.0)), radius_m))  # a chord of 6 m
        expected = (radius_m * sin(further), radius_m * (1.0 - cos(further)))
        assert line.ahead(x, y, 6.0) == pytest.approx(expected, abs=1e-3)


def test_the_point_ahead_is_the_foot_where_the_line_is_farther_than_the_reach() -> None:
    assert Polyline(STRAIGHT).ahead(7.25, 9.0, 5.0) == pytest.approx((7.25, 0.0))


def test_the_point_ahead_never_lies_beyond_the_end() -> None:
    assert Polyline(STRAIGHT[:11]).ahead(8.0, 0.0, 5.0) == pytest.approx((10.0, 0.0))


def test_before_the_start_the_line_begins_at_its_start() -> None:
    line = Polyline(STRAIGHT)
    assert line.ahead(-1.35, 0.0, 5.0) == pytest.approx((3.65, 0.0))
    assert line.nearest(-1.35, 0.2) == pytest.approx((0.2, 0.0))


def test_passed_segments_are_never_revisited() -> None:
    """At a self-intersection the route continues forward."""
    line = Polyline(STRAIGHT)
    for x in range(0, 40, 5):
        line.nearest(float(x), 0.0)
    assert line.ahead(3.0, 0.0, 5.0)[0] >= 34.0
