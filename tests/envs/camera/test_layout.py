"""Lanes of a network as shapes: neighbours meet where the network leaves a crack between them."""

from types import SimpleNamespace

import numpy as np
import pytest
from highway_env.road.lane import StraightLane
from highway_env.road.road import RoadNetwork

from vpf_sim.envs.camera.layout import lane_shapes


@pytest.mark.parametrize(("gap_m", "left_m"), [(0.0, 2.0), (0.09, 2.0), (0.5, 2.5)])
def test_a_crack_between_two_lanes_is_closed_and_a_gap_is_not(gap_m: float, left_m: float) -> None:
    network = RoadNetwork()
    for y in (0.0, 4.0 + gap_m):
        network.add_lane("a", "b", StraightLane([0.0, y], [100.0, y], width=4.0))
    first, second = lane_shapes(SimpleNamespace(network=network))
    on_lane = (second.s_m >= 0.0) & (second.s_m <= 100.0)
    assert first.right_m[:, 1] == pytest.approx(2.0)
    assert second.left_m[on_lane, 1] == pytest.approx(left_m)
    assert np.ptp(second.right_m[:, 1]) == 0.0
