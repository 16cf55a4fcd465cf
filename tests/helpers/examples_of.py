"""Properties that hold for any example: fifty of them, and a thousand in the slow tests."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

MANY = [50, pytest.param(1000, marks=pytest.mark.slow)]


def check(examples: int, strategy: st.SearchStrategy[Any], holds: Callable[[Any], None]) -> None:
    """Whether a property holds for that many examples: the same ones in every run of the fast tests."""
    chosen = settings(
        max_examples=examples,
        database=None,
        derandomize=examples < 1000,
        suppress_health_check=list(HealthCheck),
    )
    chosen(given(strategy)(holds))()
