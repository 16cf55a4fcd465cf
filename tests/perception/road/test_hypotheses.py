"""What the judgement of the lanes rests on: medians of samples that are known in part, places without derivatives."""

import numpy as np
import pytest

from vpf_sim.perception.road.hypotheses import NUMBERS, median_of_known
from vpf_sim.perception.road.model import seen_lines, seen_places, state_of
from vpf_sim.seeding import stream
from vpf_sim.types import Camera


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
