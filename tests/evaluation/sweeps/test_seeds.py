"""Seeds as text and as numbers."""

from collections.abc import Iterable
from itertools import count
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.plan import make_plan, parse_seeds, seeds_text

GRID = {"scenario": ["straight"], "weather": ["clear"], "driver": ["pid"]}


@given(st.lists(st.integers(0, 10**18 - 2), min_size=1, unique=True) | st.sets(st.integers(0, 30), min_size=1))
def test_text_of_seeds_names_the_same_seeds_in_their_order(seeds: Iterable[int]) -> None:
    assert list(parse_seeds(seeds_text(seeds, "seeds"))) == list(seeds)


@pytest.mark.parametrize(
    ("seeds", "text"),
    [
        ([3, 7], "3,7"),
        ([3], "3:4"),
        ([3, 4, 5, 9], "3:6,9"),
        ([9, 3, 4], "9,3:5"),
        (range(0, 9, 3), "0,3,6"),
        ((7, np.int64(8)), "7:9"),
        ((seed for seed in (1, 5)), "1,5"),
    ],
)
def test_seeds_that_follow_each_other_are_a_range(seeds: Iterable[int], text: str) -> None:
    assert seeds_text(seeds, "seeds") == text


@pytest.mark.parametrize("seeds", ["3, 7", [7, 3], "0:2,9", "5:6"])
def test_a_plan_takes_lists_and_texts(seeds: Any) -> None:
    expected = {"3, 7": [3, 7], "0:2,9": [0, 1, 9], "5:6": [5]}.get(str(seeds), seeds)
    plan = make_plan({**GRID, "seeds": seeds}, "sweep.toml")
    assert [job.seed for job in plan.jobs()] == list(expected)


@pytest.mark.parametrize("text", ["3", "3,", ",", "3,-7", "3;7", "3,7:5", "1:2:3", "a,b", "3,4,3", "0:5,2", "1.0,2"])
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"\A--seeds: expected [^\n]+\Z"):
        parse_seeds(text)


@pytest.mark.parametrize(
    "seeds", [[], None, 3, [True], [1.0], ["3"], [[3]], [-1], [10**18], [4, 4], {"a": 1}, [None], count()]
)
def test_other_values_are_refused(seeds: Any) -> None:
    with pytest.raises(InputError, match=r"\Aseeds: expected [^\n]+\Z"):
        seeds_text(seeds, "seeds")
