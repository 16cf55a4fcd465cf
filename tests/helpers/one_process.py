"""Sweeps, exports and the like without worker processes, each of which takes seconds to start."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from vpf_sim.evaluation import pool


@contextmanager
def one_process() -> Iterator[None]:
    """Their tasks are done in this process, as in one that may start no others."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pool, "may_start", lambda: False)
        yield
