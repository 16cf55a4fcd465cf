"""Charts of paths: the drawn road, and whose obstacles."""

import numpy as np
import pytest

from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.reporting.paths import Track, charts
from vpf_sim.reporting.road_layout import layouts

SEEDS = [0, 1, 2, 3]


@pytest.mark.parametrize("scenario", ["town04", "random"])
def test_no_path_is_drawn_over_an_obstacle_of_another_road(scenario: str) -> None:
    """On roads of their own, what stands in the way of one seed would seem to be driven through by another."""
    found = layouts(scenario, SEEDS)
    obstacles = sum(len(layout.static_obstacles) for layout in found.values())
    driven = {"route_m": np.array([0.0, 300.0]), "lane_offset_m": np.array([-9.0, 6.0])}  # over both edges
    table = StepTable(np.zeros((2, len(Step._fields)))).replaced(driven)
    chart = charts(found, [Track(seed, "driver-1", True, table) for seed in SEEDS], scenario)[1]
    own_roads = scenario == "random"
    assert obstacles > 0
    assert chart.svg.count('class="path driver-1"') == len(SEEDS)
    assert chart.svg.count('class="obstacle"') == (0 if own_roads else obstacles)
    assert chart.svg.count('class="edge"') > 0
    assert ("its own road and obstacles" in chart.caption) == own_roads
