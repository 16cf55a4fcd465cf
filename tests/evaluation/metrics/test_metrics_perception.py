"""Perception errors of synthetic estimates."""

import numpy as np
import pytest

from vpf_sim.evaluation.metrics import collision, perception

NAN = np.nan


def test_foe_errors_are_medians_over_the_frames_that_have_one() -> None:
    true = np.array([NAN, 320.0, 320.0, 320.0, 320.0])
    seen_x = np.array([300.0, 323.0, 317.0, NAN, 330.0])
    seen_y = true + np.array([0.0, 4.0, -4.0, 0.0, 0.0])
    assert perception.foe(seen_x, seen_y, true, true) == {
        "foe_median_error_px": {"x": 3.0, "y": 4.0, "distance": 5.0},
        "foe_share": 0.75,
    }


def test_a_driver_that_estimates_nothing_has_no_error() -> None:
    nothing, true = np.full(3, NAN), np.full(3, 320.0)
    assert perception.foe(nothing, nothing, true, true) == {"foe_median_error_px": None, "foe_share": 0.0}
    assert perception.foe(nothing, nothing, nothing, nothing)["foe_share"] is None
    assert perception.edges(nothing, true) == {"edge_error_10m_m": None}


def test_edge_errors() -> None:
    error = np.linspace(-0.1, 0.1, 201)
    found = perception.edges(5.0 + error, np.full(201, 5.0))["edge_error_10m_m"]
    assert found == pytest.approx({"median": 0.05, "p95": 0.095}, abs=1e-3)


def test_clearance_is_none_without_objects() -> None:
    assert collision.min_clearance_m(np.full(4, np.inf)) is None
    assert collision.min_clearance_m(np.array([np.inf, 0.8, 0.5, 2.0])) == 0.5
