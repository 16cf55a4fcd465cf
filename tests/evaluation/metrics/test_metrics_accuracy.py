"""The named accuracies on signals whose difference is known."""

import numpy as np
import pytest

from vpf_sim.evaluation.metrics.tracking import accuracy, at_distance, protocol

ZEROS = np.zeros(1000)
SINE = 0.5 * np.sin(2.0 * np.pi * np.arange(1000) / 1000.0)


def test_a_constant_difference() -> None:
    assert accuracy(SINE + 0.3, SINE, span=1.0) == pytest.approx(
        {"range": 0.85, "span": 0.7, "tolerance": 0.0, "mae": 0.3}
    )


def test_a_sine_differs_from_nothing_by_two_over_pi_of_its_amplitude() -> None:
    scores = accuracy(SINE, ZEROS, span=0.0)
    assert scores is not None
    assert scores["mae"] == pytest.approx(1.0 / np.pi, rel=1e-5)
    assert scores["tolerance"] == pytest.approx(2.0 * np.arcsin(0.2) / np.pi, abs=4e-3)
    assert scores["span"] is None, "the PID's signal never moved"


def test_the_tolerance_includes_a_tenth() -> None:
    scores = accuracy(np.array([0.1, -0.1, 0.1001, 0.0]), np.zeros(4), span=1.0)
    assert scores is not None
    assert scores["tolerance"] == 0.75


def test_the_worst_bang_bang_scores_zero_by_range() -> None:
    scores = accuracy(np.array([1.0, -1.0]), np.array([-1.0, 1.0]), span=2.0)
    assert scores == {"range": 0.0, "span": 0.0, "tolerance": 0.0, "mae": 2.0}


def test_the_parts_add_up_to_the_whole() -> None:
    passing = np.arange(1000) < 300
    scores = protocol({"throttle": np.where(passing, 0.5, 0.1)}, {"throttle": SINE * 0.0}, passing)
    parts = [scores[name]["throttle"]["mae"] for name in ("passing", "clear_of_obstacles")]  # type: ignore[index]
    assert parts == pytest.approx([0.5, 0.1])
    assert scores["throttle"]["mae"] == pytest.approx(0.3 * 0.5 + 0.7 * 0.1)  # type: ignore[index]


def test_an_empty_part_has_no_score() -> None:
    scores = protocol({"steering": SINE}, {"steering": SINE}, np.zeros(1000, bool))
    assert scores["passing"] == {"steering": None}
    assert scores["clear_of_obstacles"] == {"steering": scores["steering"]}


def test_runs_are_matched_by_distance_and_not_by_time() -> None:
    own_route_m = np.array([0.0, 0.0, 0.0, 1.0, 2.0, 2.0])  # it waits at the start and at the end
    own_signal = np.array([0.7, 0.1, 0.2, 0.5, 0.9, 0.0])
    matched = at_distance(np.array([-1.0, 0.0, 0.5, 1.0, 1.75, 9.0]), own_route_m, own_signal)
    assert matched == pytest.approx([0.7, 0.7, 0.6, 0.5, 0.8, 0.9])
