"""Objects that a driver reports are counted by their place in the lane."""

from dataclasses import replace

import ideal
import numpy as np
import pytest

from vpf_sim.replay.frame_table import columns
from vpf_sim.types import Camera, Obstacles, RoadEdges


def test_reported_objects_are_counted_by_their_place() -> None:
    edges = RoadEdges(-5.0, 5.0, 0.0, 0.0, 0.05, 1.0, 0.5, 3.0)  # the own lane from -1 to 2 m
    # forward, left, right, identity: in the lane and moving; on its left line; beside it; wide, on its right line.
    places = np.array([(12.0, 0.0, 1.6, -1.0), (7.0, -1.5, -0.9, 1.0), (9.0, -4.0, -3.0, 2.0), (30.0, 0.0, 4.4, 3.0)])
    forward, left, right, identity = places.T
    sure = np.full(4, 0.1)
    obstacles = Obstacles(forward, left, right, sure, np.full(4, 2.0), identity.astype(np.int64))
    found = columns(ideal.perception(edges, obstacles), Camera(forward_m=0.8))
    assert found["nearest_in_lane_m"] == pytest.approx(11.2)
    counts = {key.removeprefix("obstacles_"): value for key, value in found.items() if key.startswith("obstacles_")}
    assert counts == {"standing": 3, "in_lane": 1, "on_line": 2, "wide": 1}
    assert (found["obstacles"], found["flow_points"]) == (4, 0)


def test_the_own_lane_bends_with_the_road() -> None:
    edges = RoadEdges(-5.0, 5.0, 0.0, 0.01, 0.05, 1.0, 0.0, 3.0)  # 2 m to the right at 20 m
    ahead = Obstacles(*(np.array([value]) for value in (20.0, 1.5, 2.5, 0.1, 2.0)), np.array([1]))
    assert columns(ideal.perception(edges, ahead), Camera())["obstacles_in_lane"] == 1
    straight = replace(edges, curvature_per_m=0.0)
    assert columns(ideal.perception(straight, ahead), Camera())["obstacles_in_lane"] == 0
