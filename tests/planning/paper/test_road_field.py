"""The Morse field of the road: its values, which have their minimum on a lane line, and the curved form."""

from dataclasses import replace

import numpy as np
import pytest
from paper_planner import PAPER

from vpf_sim.planning.paper.road_field import FoeBend, curved_printed, curved_repaired, force, straight
from vpf_sim.types import Camera

RIGHT, LEFT = 5.25, -8.75
REPAIRED = PAPER.road_field
PRINTED = replace(REPAIRED, shape="printed")


@pytest.mark.parametrize(
    ("y", "potential", "slope"),
    [
        (-8.75, 7.23e11, -1.45e12),
        (-5.25, 6.59e8, -1.32e9),
        (-3.5, 1.99e7, -3.98e7),
        (-1.75, 1.200e6, 0.0),
        (0.0, 1.99e7, 3.98e7),
        (1.75, 6.59e8, 1.32e9),
        (5.25, 7.23e11, 1.45e12),
    ],
)
def test_the_values_across_the_road(y: float, potential: float, slope: float) -> None:
    """U_s = A (1 - e^(y_r - y))^2 + A (1 - e^(y - y_l))^2 with A = 0.5, and its derivative."""
    assert straight(y, RIGHT, LEFT) == pytest.approx(potential, rel=5e-3)
    for config in (PRINTED, REPAIRED):
        assert force(y, RIGHT, LEFT, 0, config)[1] == pytest.approx(slope, rel=5e-3, abs=1e2)


@pytest.mark.parametrize("c2", [0.005, -0.005, 5e-6])
@pytest.mark.parametrize("x", [0.0, 5.0, 27.5])
@pytest.mark.parametrize("y", [-6.0, -1.75, 0.0, 3.0])
def test_the_curved_form_is_a_stretched_straight_one(x: float, y: float, c2: float) -> None:
    printed = curved_printed(x, y, RIGHT, LEFT, c2, 2, PRINTED)
    assert curved_repaired(x, y, RIGHT, LEFT, c2, 2, REPAIRED) == pytest.approx(printed, rel=1e-6)


def test_the_printed_straight_road_drifts_sideways() -> None:
    """c_2 = 0.005 with n = 1 moves the edges by 0.1375 m over the horizon of 27.5 m; the values look swapped."""
    minimum = min(np.linspace(-3.0, 0.0, 3001), key=lambda y: curved_printed(27.5, y, RIGHT, LEFT, 0.005, 1, PRINTED))
    assert minimum == pytest.approx(-1.75 + 0.1375, abs=2e-3)


def test_a_bend_has_no_influence_on_the_force_at_the_vehicle() -> None:
    for config in (PRINTED, REPAIRED):
        left, ahead, right = (force(0.4, RIGHT, LEFT, bend, config)[1] for bend in (-1, 0, 1))
        assert left == pytest.approx(ahead, rel=1e-6)
        assert right == pytest.approx(ahead, rel=1e-6)


def test_the_force_stays_finite_far_off_the_road() -> None:
    for config in (PRINTED, REPAIRED):
        assert np.all(np.isfinite(force(-900.0, RIGHT, LEFT, 1, config)))


def test_the_bend_is_detected_by_the_median_of_the_foe_beyond_a_dead_band() -> None:
    bend = FoeBend(REPAIRED, Camera(), rate_hz=10.0)  # 5 frames
    assert [bend.update(319.5 + x) for x in (3.0, 90.0, 3.0, 3.9, -3.0)] == [0, 1, 0, 0, 0]
    assert [bend.update(319.5 + x) for x in (10.0, 10.0, 10.0)] == [0, 0, 1]
    assert [bend.update(319.5 - 10.0) for _ in range(4)] == [1, 1, -1, -1]
