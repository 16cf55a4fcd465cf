"""Mounting angles: prior, interval, and when they are used."""

import numpy as np
import pytest

from vpf_sim.replay.mounting_estimate import CORRELATED_S, Angle, angle
from vpf_sim.seeding import stream

PRIOR, FIT = 0.05, 0.002
TRUE = -0.06


def found(count: int, seconds: float, scatter_rad: float, seed: int = 0) -> Angle:
    observed = TRUE + stream(seed, "sightings").normal(0.0, scatter_rad, count)
    return angle(observed, np.full(count, FIT), PRIOR, seconds)


def test_long_straight_drive_gives_a_correct_angle_in_use() -> None:
    result = found(100, 10.0, 0.01)
    assert result.is_used
    assert result.used_rad == pytest.approx(TRUE, abs=result.half_width_rad)
    assert result.half_width_rad < np.radians(0.6)


@pytest.mark.parametrize(
    ("count", "seconds", "scatter_rad"),
    [(6, 0.24, 0.002), (25, 0.9, 0.002), (30, 5.0, 0.1)],
    ids=["six observations", "25 observations", "large scatter"],
)
def test_too_short_or_scattered_drive_is_not_used(count: int, seconds: float, scatter_rad: float) -> None:
    result = found(count, seconds, scatter_rad)
    assert not result.is_used
    assert result.used_rad == 0.0


def test_no_observations_give_the_prior() -> None:
    result = angle(np.empty(0), np.empty(0), PRIOR, 0.0)
    assert (result.rad, result.sd_rad, result.is_used) == (0.0, PRIOR, False)


def test_noisy_observations_shrink_to_the_prior() -> None:
    sizes = [abs(found(20, 2.0, scatter).rad) for scatter in (0.001, 0.1, 0.4)]
    assert sizes[0] == pytest.approx(abs(TRUE), rel=0.02)
    assert sizes[2] < 0.8 * sizes[0]


def test_interval_contains_the_truth() -> None:
    """Observations on one stretch of road share its errors."""
    held = []
    for seed in range(200):
        stretches = stream(seed, "stretches").normal(0.0, 0.01, 20)
        observed = TRUE + np.repeat(stretches, 5)
        result = angle(observed, np.full(100, FIT), PRIOR, 20 * CORRELATED_S)
        held.append(abs(result.rad - TRUE) < result.half_width_rad)
    assert np.mean(held) > 0.9
