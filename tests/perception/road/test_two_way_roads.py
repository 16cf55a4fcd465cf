"""Lanes of oncoming traffic: a solid line on the left, with a lane and another solid line beyond."""

import numpy as np
import pytest
from followed_road import followed

from vpf_sim.types import RoadEdges

WEATHERS = ("clear", "rain", "ClearNight")
BEGINS, ENDS = 150, 220  # frames; 14 m are enough to know the road


def tracked(scenario: str, weather: str, seed: int) -> list[RoadEdges]:
    """The road that is seen, once it should be known."""
    return [road for road, _ in followed(scenario, weather, seed, ENDS)][BEGINS:]


@pytest.mark.parametrize(
    ("seed", "weather"),
    [(0, "clear"), (1, "rain"), *(pytest.param(k, w, marks=pytest.mark.slow) for k in (2, 3) for w in WEATHERS)],
)
def test_the_solid_line_before_oncoming_traffic_is_the_left_edge(seed: int, weather: str) -> None:
    roads = tracked('base = "oncoming"\nschema = 1\nbodies = []\n', weather, seed)
    assert np.mean([abs(road.oncoming_m - 3.5) < 0.3 for road in roads]) > 0.9
    assert np.mean([abs(road.right_m - road.left_m - 3.5) < 0.3 for road in roads]) > 0.9


@pytest.mark.parametrize(
    ("base", "weather"),
    [
        ("curve-left", "clear"),
        ("town04-clean", "rain"),
        *(pytest.param(base, w, marks=pytest.mark.slow) for base in ("straight", "town04") for w in WEATHERS),
    ],
)
def test_a_road_of_one_direction_has_none(base: str, weather: str) -> None:
    roads = tracked(f'base = "{base}"\nschema = 1\n', weather, 2)
    assert not any(road.oncoming_m for road in roads)
