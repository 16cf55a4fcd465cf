"""Tests run side by side: OpenCV has one thread, and worker processes start where a test needs them."""

from collections.abc import Iterator

import pytest
from one_process import one_process

from vpf_sim.system import limit_opencv

limit_opencv()


@pytest.fixture
def in_one_process() -> Iterator[None]:
    """Episodes of sweeps and exports run in the test's process, as in a worker of multiprocessing."""
    with one_process():
        yield
