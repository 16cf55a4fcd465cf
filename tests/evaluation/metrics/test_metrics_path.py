"""Path error and completion on curves whose answer is known in closed form."""

import numpy as np
import pytest

from vpf_sim.evaluation.metrics import tracking

STRAIGHT = np.column_stack([np.arange(0.0, 101.0), np.zeros(101)])


def test_a_constant_offset_costs_its_square() -> None:
    positions = np.column_stack([np.linspace(0.0, 100.0, 777), np.full(777, -0.6)])
    assert tracking.path_mse(positions, STRAIGHT) == pytest.approx(0.36)


def test_a_sine_about_the_path_costs_half_its_squared_amplitude() -> None:
    x = np.linspace(0.0, 100.0, 10001)[:-1]
    positions = np.column_stack([x, 0.8 * np.sin(2.0 * np.pi * x / 20.0)])
    assert tracking.path_mse(positions, STRAIGHT) == pytest.approx(0.32)


def test_a_circle_inside_a_circle_costs_the_squared_difference_of_radii() -> None:
    angle = np.arange(0.0, 1.5, 0.01)  # waypoints 1 m apart at R = 100 m are 1.25 mm off the arc
    arc = 100.0 * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])
    inner = np.linspace(0.0, 1.49, 500)
    positions = np.column_stack([98.0 * np.sin(inner), 100.0 - 98.0 * np.cos(inner)])
    assert tracking.path_mse(positions, arc) == pytest.approx(4.0, abs=4.0 * 0.00126)


def test_lag_along_the_path_costs_nothing_but_distance_beyond_its_end_does() -> None:
    assert tracking.path_mse(np.array([[3.7, 0.0], [90.1, 0.0]]), STRAIGHT) == pytest.approx(0.0)
    assert tracking.path_mse(np.array([[103.0, 4.0]]), STRAIGHT) == pytest.approx(25.0)


def test_no_positions_have_no_error() -> None:
    assert tracking.path_mse(np.empty((0, 2)), STRAIGHT) is None


def test_a_path_is_shortened_between_waypoints() -> None:
    short = tracking.shorten(STRAIGHT, 20.25)
    assert len(short) == 22
    assert short[-1] == pytest.approx([20.25, 0.0])
    assert tracking.shorten(STRAIGHT, 500.0) is STRAIGHT


@pytest.mark.parametrize(
    ("route_m", "share"), [([0.0, 50.0], 0.25), ([0.0, 210.0], 1.0), ([30.0, 10.0], 0.15), ([-1.0], 0.0), ([], 0.0)]
)
def test_completion_is_the_furthest_place_reached(route_m: list[float], share: float) -> None:
    assert tracking.completion(np.array(route_m), 200.0) == share
