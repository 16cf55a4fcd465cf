"""psi_d = atan(F_Y' / F_X'): the printed arc tangent, its repair, and the force that vanishes."""

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest
from paper_planner import PAPER

from vpf_sim.planning.paper.reference import HeadingReference
from vpf_sim.types import Floats


def along(angle_deg: float) -> Floats:
    return np.array([cos(radians(angle_deg)), sin(radians(angle_deg))])


@pytest.mark.parametrize("angle", [-179.0, -90.0, -20.0, 0.0, 60.0, 120.0, 179.0])
def test_the_repaired_heading_is_the_direction_of_the_force(angle: float) -> None:
    heading = HeadingReference(PAPER.reference, 0.0).update(7.0 * along(angle))
    assert heading == pytest.approx(radians(angle), abs=1e-12)


def test_the_printed_arc_tangent_cannot_tell_ahead_from_behind() -> None:
    printed = HeadingReference(replace(PAPER.reference, heading="printed"), 0.0)
    assert printed.update(along(60.0)) == pytest.approx(radians(60.0))
    assert printed.update(along(120.0)) == pytest.approx(radians(-60.0))


@pytest.mark.parametrize("kind", ["printed", "repaired"])
def test_without_a_force_the_last_heading_holds(kind: str) -> None:
    reference = HeadingReference(replace(PAPER.reference, heading=kind), 0.8)
    assert reference.update(np.zeros(2)) == 0.8
    reference.update(along(20.0))
    assert reference.update(np.zeros(2)) == pytest.approx(radians(20.0))
