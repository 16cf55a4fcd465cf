"""Tests run side by side: OpenCV has one thread, and worker processes start where a test needs them.

Examples of properties are the same in each run, and none is too slow: a busy machine is no fault.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from one_process import one_process
from short_scenario import write_short

from vpf_sim.system import limit_opencv

limit_opencv()
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.fixture
def in_one_process() -> Iterator[None]:
    """Episodes of sweeps and exports run in the test's process, as in a worker of multiprocessing."""
    with one_process():
        yield


@pytest.fixture
def short(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of the shortest drive, in a folder of its own, which is the working directory."""
    monkeypatch.chdir(tmp_path)
    return write_short(tmp_path)
