"""Gaps between rectangles against the exact distance, and what is priced."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_scene import road, tracks

from vpf_sim.envs.contacts import distance
from vpf_sim.planning.spacetime.obstacles import Body, gaps
from vpf_sim.scene import predict

COORDINATE = st.floats(-8.0, 8.0)
ANGLE = st.floats(-3.1, 3.1)
NOW = np.array([0.0])


def rectangle(x_m: float, y_m: float, heading_rad: float, length_m: float, width_m: float) -> SimpleNamespace:
    return SimpleNamespace(position=np.array([x_m, y_m]), heading=heading_rad, LENGTH=length_m, WIDTH=width_m)


def largest_gap(
    place: tuple[float, float, float], size: tuple[float, float], quantile: float = 0.0, sigma: float = 0.0
) -> float:
    """Of the object at a place to a car of 4.5 x 1.9 m at the origin."""
    made = tracks(road(), (*place, 0.0, *size))
    made.covariance[0, 0, 0] = sigma**2
    one = np.zeros((1, 1), np.float32)
    body = Body(one, one, one + 1.0, one, one, 2.25, 0.95)
    found = gaps(body, predict(road(), made, NOW), 0, (0.0, 0.0), quantile)
    return float(np.max([found.along, found.across, found.object_axes]))


@given(COORDINATE, COORDINATE, ANGLE, st.floats(0.3, 6.0), st.floats(0.3, 3.0))
def test_rectangles_overlap_where_no_axis_parts_them(
    x_m: float, y_m: float, heading_rad: float, length_m: float, width_m: float
) -> None:
    exact_m = distance(rectangle(0.0, 0.0, 0.0, 4.5, 1.9), rectangle(x_m, y_m, heading_rad, length_m, width_m))
    gap_m = largest_gap((x_m, y_m, heading_rad), (length_m, width_m))
    assert gap_m <= exact_m + 1e-4  # an axis shows at most the distance
    if abs(gap_m) > 1e-4:
        assert (gap_m < 0.0) == (exact_m == 0.0)


@pytest.mark.parametrize("quantile", [1.0, 2.0])
def test_an_uncertain_object_is_longer(quantile: float) -> None:
    assert largest_gap((10.0, 0.0, 0.0), (4.0, 2.0), quantile, 0.5) == pytest.approx(10.0 - 2.25 - 2.0 - 0.5 * quantile)
