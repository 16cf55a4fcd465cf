"""Chattering of signals with known direction changes and variation."""

from typing import Any

import numpy as np
import pytest

from vpf_sim.evaluation.metrics.comfort import chattering, direction_changes
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.types import Floats

TIME_S = np.arange(601) / 60.0
LIMIT_RAD = np.radians(40.0)


def drive(steering: Floats, throttle: Floats | None = None) -> Any:
    """The score of 600 commands over 10 s and the row that ends it."""
    pedal = np.zeros(600) if throttle is None else throttle
    rows = [
        Step(t, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, np.inf, throttle=u, steering=w)
        for t, u, w in zip(TIME_S, [*pedal, np.nan], [*steering, np.nan], strict=True)
    ]
    return chattering(StepTable.of(rows))


def test_a_sine_turns_twice_a_period_and_varies_by_four_amplitudes() -> None:
    found = drive(0.3 * np.sin(2.0 * np.pi * 0.5 * TIME_S[:600]))
    assert found["steering"]["direction_changes_per_s"] == pytest.approx(1.0, abs=0.01)
    assert found["steering"]["total_variation_per_s"] == pytest.approx(0.5 * 4.0 * 0.3, rel=0.01)
    assert found["steering_rate_radps"]["max"] == pytest.approx(0.3 * np.pi * LIMIT_RAD, rel=1e-3)
    assert found["throttle"] == {"direction_changes_per_s": 0.0, "total_variation_per_s": 0.0}


def test_bang_bang_turns_at_every_frame() -> None:
    found = drive(np.zeros(600), throttle=np.where(np.arange(600) % 2 == 0, 0.36, -0.36))
    assert found["throttle"]["direction_changes_per_s"] == pytest.approx(60.0, rel=0.005)
    assert found["throttle"]["total_variation_per_s"] == pytest.approx(60.0 * 0.72)
    assert found["steering_rate_radps"] == {"p95": 0.0, "max": 0.0}


def test_a_ramp_never_turns_and_its_rate_is_its_slope() -> None:
    found = drive(-0.5 + TIME_S[:600] / 10.0)
    assert found["steering"]["direction_changes_per_s"] == 0.0
    assert found["steering_rate_radps"]["p95"] == pytest.approx(0.1 * LIMIT_RAD)


def test_pauses_and_rounding_are_no_direction_changes() -> None:
    assert direction_changes(np.array([0.0, 0.1, 0.1, 0.1, 0.2])) == 0
    assert direction_changes(np.array([0.0, 0.1, 0.1, 0.0])) == 1
    assert direction_changes(0.5 + 1e-9 * np.array([0.0, 1.0, 0.0, 1.0])) == 0


def test_one_command_is_no_signal() -> None:
    assert chattering(StepTable.of([Step(*[0.0] * 9), Step(*[0.0] * 9)])) is None
