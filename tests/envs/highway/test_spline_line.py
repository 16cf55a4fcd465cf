"""The spline through points of a circle: places, heading and curvature in closed form."""

import numpy as np
import pytest

from vpf_sim.envs.highway.lanes import SplineLine
from vpf_sim.geometry import unwrapped

RADIUS_M = 30.0


def circle(turns: float = 0.5) -> SplineLine:
    """A circle about the origin from (R, 0), turning right (clockwise, y down)."""
    angle = np.linspace(0.0, 2.0 * np.pi * turns, round(2.0 * np.pi * RADIUS_M * turns) + 1)
    return SplineLine(RADIUS_M * np.column_stack([np.cos(angle), np.sin(angle)]))


def test_position_and_local_are_inverse_to_each_other() -> None:
    line, rng = circle(), np.random.default_rng(1)
    s, lateral = rng.uniform(-20.0, line.length_m + 20.0, 200), rng.uniform(-10.0, 10.0, 200)
    back = np.array([line.local_at(*line.position_at(*place)) for place in zip(s, lateral, strict=True)])
    assert back == pytest.approx(np.column_stack([s, lateral]), abs=1e-6)


def test_a_circle_has_its_curvature_and_headings() -> None:
    line = circle()
    s = np.linspace(5.0, line.length_m - 5.0, 50)
    assert line.curvature(s) == pytest.approx(1.0 / RADIUS_M, rel=1e-3)
    assert unwrapped(line.heading(s)) == pytest.approx(np.pi / 2.0 + s / RADIUS_M, abs=2e-3)
    assert line.curvature([-1.0, line.length_m + 1.0]) == pytest.approx(0.0), "straight beyond the ends"


def test_a_point_of_a_second_lap_is_found_near_its_place() -> None:
    line, lap_m = circle(turns=2.0), 2.0 * np.pi * RADIUS_M
    x, y = line.position_at(20.0, 1.0)
    assert line.local_at(x, y, 25.0) == pytest.approx((20.0, 1.0), abs=1e-3)
    assert line.local_at(x, y, lap_m + 15.0) == pytest.approx((lap_m + 20.0, 1.0), abs=0.02)
