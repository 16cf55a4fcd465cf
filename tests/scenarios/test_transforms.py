"""Rotated, translated and mirrored scenarios: all positions follow."""

from math import radians

import numpy as np
import pytest
from transforms import mirrored, rotated, translated

from vpf_sim import scenarios
from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.geometry import rotation
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Floats

ALONG = np.linspace(0.0, 150.0, 16)


def drawn(name: str, seed: int = 7) -> Scenario:
    return scenarios.load(name).draw(seed)


def places(scenario: Scenario) -> Floats:
    """(N, 2) m, points of both edges, the ego and the objects."""
    road, line = scenario.road, CentreLine(scenario.road)
    edges = [line.position(ALONG, side * road.half_width_m) for side in (1.0, -1.0)]
    items = [scenario.ego, *scenario.bodies]
    spots = [line.position_at(part.s_m, road.lane_offset_m(part.lane) + part.lateral_m) for part in items]
    return np.concatenate([*edges, np.array(spots)])


@pytest.mark.parametrize("name", ["town04", "random", "curve-left"])
def test_rotated_and_translated_positions_follow_the_rigid_motion(name: str) -> None:
    scenario = drawn(name)
    there = places(translated(rotated(scenario, 137.0), 600.0, -800.0))
    assert there == pytest.approx(places(scenario) @ rotation(radians(137.0)).T + [600.0, -800.0], abs=1e-6)


@pytest.mark.parametrize("name", ["town04", "random", "curve-left"])
def test_mirrored_scenario_swaps_left_and_right(name: str) -> None:
    scenario = drawn(name)
    count = 2 * len(ALONG)
    here, there = places(scenario), places(mirrored(scenario))
    swapped = np.concatenate([here[count // 2 : count], here[: count // 2], here[count:]])
    assert there == pytest.approx(swapped * [1.0, -1.0], abs=1e-6)
    assert mirrored(scenario).ego.heading_deg == -scenario.ego.heading_deg
    assert mirrored(mirrored(scenario)) == scenario


def test_mirrored_intervals_change_sign() -> None:
    varied = scenarios.load("town04")
    assert isinstance(varied, Scenario)
    skewed = varied.model_copy(update={"vary": {"ego.lateral_m": (-0.1, 0.3), "bodies.s_m": (-1.0, 3.0)}})
    assert mirrored(skewed).vary == {"ego.lateral_m": (-0.3, 0.1), "bodies.s_m": (-1.0, 3.0)}
