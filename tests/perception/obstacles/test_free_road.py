"""Bodies that are told where looks show the road, or something on it, or too little."""

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
    """At which look the body is cleared, at each of which this was seen."""
    clearing, one = FreeRoadEvidence(section("static_obstacles.free_road")), np.array([7])
    return [k for k, value in enumerate(differences) if clearing.record(one, np.array([value]), at(k)) == [0]]


def test_a_few_looks_at_bare_road_clear_a_body() -> None:
    assert cleared([1.0] * LOOKS) == [LOOKS - 1]
    assert cleared([1.0] * (LOOKS - 1)) == []


@pytest.mark.parametrize("between", [float("nan"), 4.0])
def test_a_look_that_tells_nothing_changes_nothing(between: float) -> None:
    assert cleared([1.0, between] * LOOKS) == [2 * LOOKS - 2]


def test_a_look_at_a_body_makes_up_for_one_at_bare_road() -> None:
    assert cleared([1.0, 20.0] * 10) == []
    assert cleared([20.0] * 10 + [1.0] * LOOKS) == [9 + LOOKS]


def test_each_body_has_its_own_looks_and_one_that_is_gone_has_none() -> None:
    clearing = FreeRoadEvidence(section("static_obstacles.free_road"))
    for k in range(LOOKS - 1):
        assert clearing.record(np.array([3, 5]), np.array([1.0, 9.0]), at(k)) == []
    assert clearing.record(np.array([5, 3]), np.array([9.0, 1.0]), at(LOOKS)) == [1]
    for k in range(LOOKS - 1):
        clearing.record(np.array([3]), np.array([1.0]), at(10 + k))
    clearing.record(NONE, np.empty(0), at(20))
    assert clearing.record(np.array([3]), np.array([1.0]), at(21)) == []


def test_standing_the_same_picture_tells_nothing_new() -> None:
    clearing, one = FreeRoadEvidence(section("static_obstacles.free_road")), np.array([7])
    assert all(clearing.record(one, np.array([1.0]), np.array([0.01 * k, 0.0])) == [] for k in range(20))


def test_parts_of_one_body_are_looked_at_as_one() -> None:
    """Of one part the road is seen, of the other something that stands; of a third nothing."""
    clearing, parts, bare = (
        FreeRoadEvidence(section("static_obstacles.free_road")),
        np.array([7, 7, 7]),
        np.array([1.0, np.nan, 1.0]),
    )
    for k in range(10):
        assert clearing.record(parts, np.array([1.0, 9.0, np.nan]), at(k)) == []
    found = [clearing.record(parts, bare, at(10 + k)) for k in range(LOOKS)]
    assert found == [[]] * (LOOKS - 1) + [[0, 1, 2]]
