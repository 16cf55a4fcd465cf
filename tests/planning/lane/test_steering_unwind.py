"""Where a path comes to rest: the closed form against the path that is steered so."""

import numpy as np
import pytest

from vpf_sim.planning.lane.steering_unwind import rest
from vpf_sim.seeding import stream

STEP_M = 0.002


def steered(slope: float, bend: float, steering: float, tightest: float) -> tuple[float, float]:
    """Way and shift of a path whose bend falls as fast and as far as it may, and rises in time to end straight."""
    side = -1.0 if slope + 0.5 * bend * abs(bend) / steering < 0.0 else 1.0
    slope, bend, way, shift = side * slope, side * bend, 0.0, 0.0
    while bend > 0.0 or slope > 0.5 * bend**2 / steering:
        bend = max(bend - steering * STEP_M, -tightest)
        slope, way = slope + bend * STEP_M, way + STEP_M
        shift += slope * STEP_M
    while bend < 0.0:
        bend += steering * STEP_M
        slope, way = slope + bend * STEP_M, way + STEP_M
        shift += slope * STEP_M
    return way, side * shift


def test_the_closed_form_is_the_steered_path() -> None:
    random = stream(1, "settling")
    for _ in range(60):
        steering, tightest = random.uniform(0.02, 0.3), random.uniform(0.15, 0.25)
        slope, bend = random.uniform(-0.6, 0.6), random.uniform(-tightest, tightest)
        way, shift = rest(slope, bend, np.array([steering]), np.array([tightest]))
        expected = steered(slope, bend, steering, tightest)
        assert (way[0], shift[0]) == pytest.approx(expected, abs=0.03)


def test_a_straight_path_rests_where_it_is_and_the_mirrored_one_mirrored() -> None:
    steering, tightest = np.array([0.05, 0.2]), np.array([0.2, 0.2])
    assert np.array_equal(np.abs(rest(0.0, 0.0, steering, tightest)), np.zeros((2, 2)))
    way, shift = rest(0.3, -0.1, steering, tightest)
    mirrored = rest(-0.3, 0.1, steering, tightest)
    assert np.array_equal(mirrored[0], way)
    assert np.array_equal(mirrored[1], -shift)


def test_the_slower_the_steering_the_farther() -> None:
    steering = np.linspace(0.3, 0.02, 20)
    for bend in (0.15, 0.0, -0.1):
        way, shift = rest(0.4, bend, steering, np.full(20, 0.2))
        assert np.all(np.diff(way) > 0.0)
        assert np.all(np.diff(shift) > 0.0)
