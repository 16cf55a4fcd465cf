"""The edges of the carriageway ahead, by what was told of them here."""

import numpy as np
import pytest

from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import RoadEdges


def test_the_edges_of_the_carriageway_follow_heading_and_curvature() -> None:
    road = RoadEdges(-7.0, 7.0, 0.05, 0.01, 0.02, 1.0, 1.75, 3.5)
    left, right = carriageway_offsets(np.array([0.0, 20.0]), road)
    assert (left[0], right[0]) == pytest.approx((-7.0, 7.0), abs=0.02)
    # On circles about (x, y) = 100 m to the right of the pose, turned by the heading.
    centre = 100.0 * np.array([-np.sin(0.05), np.cos(0.05)])
    for offset, found in ((-7.0, left[1]), (7.0, right[1])):
        exact = centre[1] - np.sqrt((100.0 - offset) ** 2 - (20.0 - centre[0]) ** 2)
        assert found == pytest.approx(exact, abs=0.15)
