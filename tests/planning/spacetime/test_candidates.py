"""Paths and speed profiles against their boundary conditions, curvature against circles."""

from dataclasses import replace

import numpy as np
import pytest
from made_scene import EDGE_M, road

from vpf_sim.planning.spacetime import candidates, settings
from vpf_sim.planning.spacetime.candidates import Paths, PathState
from vpf_sim.planning.spacetime.motions import motions
from vpf_sim.types import VehicleModel

SETTINGS = settings.load().candidates
START = PathState(10.0, 0.4, 0.1, -0.02, 5.0, 0.5)
TIMES_S = np.arange(0.0, 5.01, 0.2)


def paths() -> Paths:
    return candidates.paths(SETTINGS, START, road(), 1.9, None)


def test_a_path_begins_in_the_cars_state() -> None:
    for values, expected in zip(paths().at(np.array([START.s_m])), (0.4, 0.1, -0.02), strict=True):
        np.testing.assert_allclose(values, expected, atol=1e-12)


def test_a_path_ends_straight_on_the_road() -> None:
    found = paths()
    d, slope, bend = found.at((found.start_m + found.length_m)[:, None])
    np.testing.assert_allclose(d[:, 0], found.end_m, atol=1e-9)
    np.testing.assert_allclose(slope, 0.0, atol=1e-9)
    np.testing.assert_allclose(bend, 0.0, atol=1e-9)
    assert np.abs(found.end_m).max() <= EDGE_M - 0.5 * 1.9


def test_slope_and_bend_are_the_derivatives() -> None:
    s = np.linspace(START.s_m, START.s_m + 6.0, 2001)[None]
    d, slope, bend = paths().at(s)
    np.testing.assert_allclose(np.gradient(d, s[0], axis=1)[:, 1:-1], slope[:, 1:-1], atol=1e-4)
    np.testing.assert_allclose(np.gradient(slope, s[0], axis=1)[:, 1:-1], bend[:, 1:-1], atol=1e-4)


def test_the_last_path_is_a_candidate() -> None:
    kept = paths().select(np.array([3]))
    again = candidates.paths(SETTINGS, replace(START, s_m=12.0), road(), 1.9, kept)
    assert again.start_m[-1] == 10.0
    np.testing.assert_array_equal(again.coefficients[-1], kept.coefficients[0])


def test_a_profile_begins_in_the_cars_state_and_is_never_negative() -> None:
    found = candidates.profiles(SETTINGS, START, 5.5, TIMES_S, None)
    np.testing.assert_allclose(found.speed_mps[:, 0], 5.0)
    assert found.speed_mps.min() == 0.0
    assert (np.diff(found.travelled_m, axis=1) >= 0.0).all()
    np.testing.assert_allclose(np.unique(np.round(found.speed_mps[:, -1], 6)).max(), 5.5)


@pytest.mark.parametrize("rate_mps2", [3.0, 6.0])
def test_a_full_stop_is_a_candidate(rate_mps2: float) -> None:
    found = candidates.profiles(SETTINGS, START, 5.5, TIMES_S, None)
    stops = np.abs(found.speed_mps - np.maximum(5.0 - rate_mps2 * TIMES_S, 0.0)).max(axis=1)
    assert stops.min() < 1e-9


@pytest.mark.parametrize("d_m", [-2.0, 0.0, 3.0])
def test_the_curvature_beside_a_bend_is_that_of_the_circle(d_m: float) -> None:
    bend, state = road(1.0 / 40.0), PathState(10.0, d_m, 0.0, 0.0, 5.0, 0.0)
    straight_on = Paths(np.array([10.0]), np.array([20.0]), np.array([[d_m, 0.0, 0.0, 0.0, 0.0, 0.0]]))
    profiles = candidates.profiles(SETTINGS, state, 5.0, TIMES_S, None)
    driven = motions(bend, state, straight_on, profiles, VehicleModel())
    np.testing.assert_allclose(driven.curvature_per_m, 1.0 / (40.0 - d_m), rtol=1e-4)
    x, y = driven.x_m + driven.origin_m[0], driven.y_m + driven.origin_m[1]
    np.testing.assert_allclose(np.hypot(x, y - 40.0), np.hypot(40.0 - d_m, VehicleModel().l_r_m), atol=0.01)
    np.testing.assert_allclose(driven.d_m, 40.0 - np.hypot(40.0 - d_m, VehicleModel().l_r_m), atol=0.005)
