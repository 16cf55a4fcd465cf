"""`vpf` drives by camera on a road whose lanes differ in width and change it: truth, camera and physics agree."""

from pathlib import Path

import numpy as np
import pytest

import vpf_sim
from vpf_sim import scenarios
from vpf_sim.scenarios import Scenario

# In a bend of 200 m, the right one of three lanes narrows from 3.8 to 3.2 m, and all shift to the left.
ROAD = """
schema = 1
[road]
lanes = 3
segments = [{kind = "line", length_m = 30}, {kind = "arc", length_m = 130, radius_m = -200}]
[[road.widths]]
s_m = 20.0
lanes_m = [3.8, 3.5, 3.5]
left_edge_m = -4.9
[[road.widths]]
s_m = 70.0
lanes_m = [3.2, 3.6, 3.5]
left_edge_m = -5.4
[ego]
lane = 1
[goal]
s_m = 75.0
"""


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Scenario, vpf_sim.Episode]:
    file = tmp_path_factory.mktemp("widths") / "narrowing.toml"
    Path(file).write_text(ROAD, "utf-8")
    scenario = scenarios.load(str(file))
    assert isinstance(scenario, Scenario)
    return scenario, vpf_sim.drive(file)


def test_it_arrives_in_the_middle_of_its_lane(driven: tuple[Scenario, vpf_sim.Episode]) -> None:
    _, episode = driven
    assert episode.status == "success"
    assert episode.record["max_lane_offset_m"] < 0.5


def test_the_edges_that_it_sees_are_those_of_the_road(driven: tuple[Scenario, vpf_sim.Episode]) -> None:
    """10 m ahead the carriageway is as wide as the lanes there, in truth and in its frames."""
    scenario, episode = driven
    places, steps = scenario.road.lane_places, episode.steps
    assert places is not None
    borders = places.borders(steps["route_m"].to_numpy() + 10.0)
    wide_m = borders[-1] - borders[0]
    true_m, seen_m = (steps[f"{whose}_left_m"] - steps[f"{whose}_right_m"] for whose in ("true", "seen"))
    assert np.ptp(wide_m) > 0.4
    assert np.abs(np.abs(true_m) - wide_m).max() < 0.1
    known = seen_m.notna()
    assert known.mean() > 0.9
    assert float(np.median(np.abs(steps["seen_right_m"] - steps["true_right_m"])[known])) < 0.1
    last = known & (steps["time_s"] > steps["time_s"].iloc[-1] - 2.0)
    assert float(np.median(np.abs(seen_m - true_m)[last])) < 0.1
