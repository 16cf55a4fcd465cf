"""Solid and dashed lines told apart by their gaps, against lines of known contrast, near and far, in noise."""

import numpy as np
import pytest
from driver_settings import ROBUST

from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.line_type import DashDutyCycle
from vpf_sim.perception.road.markings import RidgeMap
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Image

assert ROBUST.road_edges.hypotheses.duty is not None
DUTY = ROBUST.road_edges.hypotheses.duty
VIEW = BirdsEye(Camera(), ROBUST.road_edges.patch)
PLACES_M: Floats = np.array([-6.0, -2.0, 2.0, 6.0])
RIGHT_M = np.broadcast_to(PLACES_M[:, None], (4, len(VIEW.forward_m)))
VISIBLE: Bools = np.ones(RIGHT_M.shape, np.bool_)


def ridges(response: Image) -> RidgeMap:
    return RidgeMap(VIEW, response, 5.0, VIEW.visible, 0.15)


def driven(contrast: float, metres: float, step_m: float = 1.1) -> DashDutyCycle:
    """A solid line of so many grey levels, fading e-fold in 8 m, dashed ones of 3 m in 9 and 6 in 18, and none."""
    rng, duty = stream(34, "duty"), DashDutyCycle.start(len(PLACES_M), DUTY)
    column = np.rint((PLACES_M - VIEW.right_m[0]) / VIEW.column_m).astype(int)
    for travelled in np.arange(0.0, metres, step_m):
        response = np.maximum(rng.normal(0.0, 3.0, (len(VIEW.forward_m), len(VIEW.right_m))), 0.0)
        along = VIEW.forward_m + travelled
        painted = [along >= 0.0, along % 9.0 < 3.0, along % 18.0 < 6.0]
        for line, paint in zip(column, painted, strict=False):
            response[:, line - 1 : line + 2] += (paint * contrast * np.exp(-VIEW.forward_m / 8.0))[:, None]
        duty.look(ridges(np.rint(response).astype(np.uint8)), RIGHT_M, VISIBLE, float(travelled))
    return duty


@pytest.mark.parametrize("contrast", [250.0, 60.0, 25.0])
def test_the_share_that_is_painted_does_not_depend_on_the_contrast(contrast: float) -> None:
    """The faintest has 12 grey levels at 6 m and 2 at 20 m, in noise of 3."""
    share, known = driven(contrast, 60.0).duty()
    assert known[:3].all()
    assert share[0] > 0.8
    assert share[1:3] == pytest.approx(1.0 / 3.0, abs=0.12)


def test_what_is_no_line_is_neither_solid_nor_dashed() -> None:
    _, known = driven(60.0, 60.0).duty()
    assert not known[3]


def test_nothing_is_known_before_a_dash_and_its_gap_have_passed_nor_by_standing() -> None:
    assert not driven(60.0, DUTY.least_memory_m - 1.0).duty()[1].any()
    assert not driven(60.0, 0.02, 1e-4).duty()[1].any()


def test_one_look_after_a_gap_tells_nothing_of_the_road_in_between() -> None:
    duty = driven(60.0, 2.0)
    response = np.full((len(VIEW.forward_m), len(VIEW.right_m)), 60, np.uint8)
    duty.look(ridges(response), RIGHT_M, VISIBLE, 40.0)
    assert not duty.duty()[1].any()
