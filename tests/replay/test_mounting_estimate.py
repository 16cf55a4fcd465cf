"""The angles of a mounting: the prior, the interval, and when they are used."""

import numpy as np
import pytest

from vpf_sim.replay.mounting_estimate import CORRELATED_S, Angle, angle
from vpf_sim.seeding import stream

PRIOR, FIT = 0.05, 0.002
TRUE = -0.06


def found(count: int, seconds: float, scatter_rad: float, speed_mps: float = 12.0, seed: int = 0) -> Angle:
    seen = TRUE + stream(seed, "sightings").normal(0.0, scatter_rad, count)
    return angle(seen, np.full(count, FIT), PRIOR, seconds, seconds * speed_mps)


def test_a_long_straight_way_is_used_and_right() -> None:
    told = found(100, 10.0, 0.01)
    assert told.is_used
    assert told.used_rad == pytest.approx(TRUE, abs=told.half_width_rad)
    assert told.half_width_rad < np.radians(0.6)


@pytest.mark.parametrize(
    ("count", "seconds", "scatter_rad", "speed_mps"),
    [(6, 0.24, 0.002, 12.0), (25, 0.9, 0.002, 12.0), (30, 5.0, 0.1, 12.0), (40, 4.0, 0.002, 1.5)],
    ids=["six sightings", "25 sightings", "they scatter", "hardly any way"],
)
def test_too_little_is_not_used(count: int, seconds: float, scatter_rad: float, speed_mps: float) -> None:
    told = found(count, seconds, scatter_rad, speed_mps)
    assert not told.is_used
    assert told.used_rad == 0.0


def test_nothing_seen_leaves_the_prior() -> None:
    told = angle(np.empty(0), np.empty(0), PRIOR, 0.0, 0.0)
    assert (told.rad, told.sd_rad, told.is_used) == (0.0, PRIOR, False)


def test_the_rougher_the_sightings_the_nearer_to_straight_ahead() -> None:
    sizes = [abs(found(20, 2.0, scatter).rad) for scatter in (0.001, 0.1, 0.4)]
    assert sizes[0] == pytest.approx(abs(TRUE), rel=0.02)
    assert sizes[2] < 0.8 * sizes[0]


def test_the_interval_holds_the_truth() -> None:
    """Sightings that share the errors of their stretch, as those of one stretch do."""
    held = []
    for seed in range(200):
        stretches = stream(seed, "stretches").normal(0.0, 0.01, 20)
        seen = TRUE + np.repeat(stretches, 5)
        told = angle(seen, np.full(100, FIT), PRIOR, 20 * CORRELATED_S, 60.0)
        held.append(abs(told.rad - TRUE) < told.half_width_rad)
    assert np.mean(held) > 0.9
