"""Bodies that are told where looks show the road, or something on it, or too little."""

import numpy as np
import pytest

from vpf_sim.perception.clearing import Clearing, ClearingConfig

LOOKS = ClearingConfig().looks
NONE = np.empty(0, np.int64)


def cleared(differences: list[float]) -> list[int]:
    """At which look the body is cleared, at each of which this was seen."""
    clearing, one = Clearing(ClearingConfig()), np.array([7])
    return [k for k, value in enumerate(differences) if clearing.record(one, np.array([value])) == [0]]


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
    clearing = Clearing(ClearingConfig())
    for _ in range(LOOKS - 1):
        assert clearing.record(np.array([3, 5]), np.array([1.0, 9.0])) == []
    assert clearing.record(np.array([5, 3]), np.array([9.0, 1.0])) == [1]
    for _ in range(LOOKS - 1):
        clearing.record(np.array([3]), np.array([1.0]))
    clearing.record(NONE, np.empty(0))
    assert clearing.record(np.array([3]), np.array([1.0])) == []


@pytest.mark.parametrize("wrong", [{"road": 0.0}, {"road": 6.0}, {"looks": 0}])
def test_nonsense_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="expected"):
        ClearingConfig(**wrong)  # type: ignore[arg-type]
