"""One run, exported once in each format."""

from pathlib import Path

import driven_short
import pytest
from driven_short import Driven
from one_process import one_process

import vpf_sim

SIZE = (64, 48)


@pytest.fixture(scope="session")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Driven:
    return driven_short.drive(tmp_path_factory.mktemp("driven"))


@pytest.fixture(scope="session")
def lerobot_set(driven: Driven, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """In full size and colour."""
    out = tmp_path_factory.mktemp("sets") / "lerobot"
    with one_process():
        return vpf_sim.export(driven.path, "lerobot", out=out, workers=1).path


@pytest.fixture(scope="session")
def minari_set(driven: Driven, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """In full size and colour."""
    with one_process():
        return vpf_sim.export(driven.path, "minari", out=tmp_path_factory.mktemp("sets") / "drives-v2", workers=1).path


@pytest.fixture(scope="session")
def small_set(driven: Driven, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Minari's, small and grey, with ground truth."""
    truth = ("depth", "flow", "foe")
    out = tmp_path_factory.mktemp("sets") / "small"
    with one_process():
        return vpf_sim.export(driven.path, "minari", out=out, size=SIZE, grey=True, truth=truth, workers=1).path
