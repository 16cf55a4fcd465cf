"""Obstacles that are reported where looks show the road, or something on it, or too little."""

import numpy as np
import pytest
from driver_settings import section

from vpf_sim.perception.obstacles.free_road import FreeRoadEvidence
from vpf_sim.types import Floats

LOOKS = section("static_obstacles.free_road").observations
NONE = np.empty(0, np.int64)


def at(look: int) -> Floats:
    """(2,) m, where the car is at a look."""
    return np.array([0.55 * look, 0.0])


def cleared(differences: list[float]) -> list[int]:
    """At which look the obstacle is cleared, at each of which this was seen."""
    evidence, one = FreeRoadEvidence(section("static_obstacles.free_road")), np.array([7])
    return [k for k, value in enumerate(differences) if evidence.record(one, np.array([value]), at(k)) == [0]]


def test_a_few_observations_of_bare_road_delete_an_obstacle() -> None:
    assert cleared([1.0] * LOOKS) == [LOOKS - 1]
    assert cleared([1.0] * (LOOKS - 1)) == []


@pytest.mark.parametrize("between", [float("nan"), 4.0])
def test_ambiguous_observations_change_nothing(between: float) -> None:
    assert cleared([1.0, between] * LOOKS) == [2 * LOOKS - 2]


def test_an_observation_of_an_obstacle_undoes_one_of_bare_road() -> None:
    assert cleared([1.0, 20.0] * 10) == []
    assert cleared([20.0] * 10 + [1.0] * LOOKS) == [9 + LOOKS]


def test_each_obstacle_has_its_own_count() -> None:
    evidence = FreeRoadEvidence(section("static_obstacles.free_road"))
    for k in range(LOOKS - 1):
        assert evidence.record(np.array([3, 5]), np.array([1.0, 9.0]), at(k)) == []
    assert evidence.record(np.array([5, 3]), np.array([9.0, 1.0]), at(LOOKS)) == [1]
    for k in range(LOOKS - 1):
        evidence.record(np.array([3]), np.array([1.0]), at(10 + k))
    evidence.record(NONE, np.empty(0), at(20))
    assert evidence.record(np.array([3]), np.array([1.0]), at(21)) == []


def test_at_standstill_observations_do_not_count() -> None:
    evidence, one = FreeRoadEvidence(section("static_obstacles.free_road")), np.array([7])
    assert all(evidence.record(one, np.array([1.0]), np.array([0.01 * k, 0.0])) == [] for k in range(20))


def test_parts_of_an_obstacle_count_together() -> None:
    """Of one part the road is seen, of the other something that stands; of a third nothing."""
    evidence, parts, bare = (
        FreeRoadEvidence(section("static_obstacles.free_road")),
        np.array([7, 7, 7]),
        np.array([1.0, np.nan, 1.0]),
    )
    for k in range(10):
        assert evidence.record(parts, np.array([1.0, 9.0, np.nan]), at(k)) == []
    found = [evidence.record(parts, bare, at(10 + k)) for k in range(LOOKS)]
    assert found == [[]] * (LOOKS - 1) + [[0, 1, 2]]
