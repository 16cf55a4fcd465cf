"""What the judgement of the lanes rests on: medians of samples that are known in part, places without derivatives."""

import numpy as np
import pytest
from driver_settings import ROBUST

from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.hypotheses import FAR, NUMBERS, RIGHT, CarriagewayHypotheses, median_of_known
from vpf_sim.perception.road.markings import RidgeMap
from vpf_sim.perception.road.model import VERGE, seen_lines, seen_places, state_of
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Integers


@pytest.mark.parametrize("count", [1, 2, 7, 96])
def test_median_of_knowns_leaves_out_what_is_not_known(count: int) -> None:
    rng = stream(7, "samples")
    samples = rng.normal(0.0, 30.0, (8, count, 3))
    samples[:, 1:][rng.random((8, count - 1)) < 0.4] = np.nan
    assert np.array_equal(median_of_known(samples), np.nanmedian(samples, axis=1))


def test_places_are_those_that_come_with_derivatives() -> None:
    state = state_of(1.2, 0.03, 0.004, 3.4)
    state[-1] = 0.002
    forward = np.arange(4.0, 29.0, 0.7)
    right, _, reached = seen_lines(state, NUMBERS, forward, Camera())
    places, seen = seen_places(state, NUMBERS, forward, Camera())
    assert np.array_equal(places, right)
    assert np.array_equal(seen, reached)
    assert seen.any()


@pytest.mark.parametrize(("verge", "outermost"), [(np.inf, RIGHT), (-np.inf, -FAR)], ids=["right", "left"])
def test_no_lane_reaches_beyond_a_verge_but_a_shoulder_may_lie_before_it(verge: float, outermost: Integers) -> None:
    """Grey ground without a line; the verge is 10 m from line 0, so that three lanes of 3.5 m do not fit."""
    config = ROBUST.road_edges
    view, colours = BirdsEye(Camera(), config.patch), BirdsEye(Camera(), config.colour_patch)
    grey = np.full((*colours.visible.shape, 3), 100, np.uint8)
    ridges = RidgeMap(view, np.zeros(view.visible.shape, np.uint8), 10.0, view.visible, 0.15)
    state = state_of(1.75, 0.0, 0.0, 3.5)
    state[VERGE[verge]] = np.sign(verge) * 10.0
    known, unknown = (CarriagewayHypotheses.start(4, 2, config.hypotheses) for _ in range(2))
    known.judge(state, ridges, grey, colours, [verge])
    unknown.judge(state, ridges, grey, colours, [])
    gain = known.log_odds - unknown.log_odds
    assert np.ptp(gain[outermost <= 2]) == pytest.approx(0.0, abs=1e-9)
    assert np.exp(gain[outermost > 2].max() - gain[outermost <= 2].max()) < 0.1
