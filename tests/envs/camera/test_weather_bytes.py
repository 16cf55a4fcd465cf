"""The same seed gives the same bytes under every weather, also in a fresh process and in a pool; another does not."""

import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from hashlib import sha256
from multiprocessing import get_context
from pathlib import Path

import pytest

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.gallery.poses import Path as Along
from vpf_sim.gallery.poses import ScriptedDrive
from vpf_sim.scenarios.parts import ObjectSpec
from vpf_sim.system import limit_opencv

FRAMES = 3
NAMES = list(weathers.PRESETS)
ALONE = "from test_weather_bytes import digests; print(*digests(7).values())"


def digest(name: str, seed: int) -> str:
    """Of the first frames of a drive among traffic."""
    scenario = scenarios.drawn_road("town04", 0)
    van = ObjectSpec(kind="van", s_m=160.0, lane=4, speed_mps=14.0)
    drive = ScriptedDrive(
        scenario.model_copy(update={"bodies": (*scenario.bodies, van)}), Along(152.0, 5.55, lambda _: 0.0)
    )
    shots = drive.shots(weathers.load(name), seed, FRAMES)
    return sha256(b"".join(shot.image.tobytes() for shot in shots)).hexdigest()


def digests(seed: int, names: list[str] = NAMES) -> dict[str, str]:
    limit_opencv()
    return {name: digest(name, seed) for name in names}


@pytest.fixture(scope="module")
def here() -> dict[str, str]:
    return digests(7)


def test_every_weather_gives_different_frames(here: dict[str, str]) -> None:
    assert len(set(here.values())) == len(NAMES)


@pytest.mark.parametrize("name", ["ClearNoon", "MidRainSunset", "HardRainNoon"])
def test_the_same_seed_gives_the_same_bytes_and_another_does_not(here: dict[str, str], name: str) -> None:
    assert digest(name, 7) == here[name]
    assert digest(name, 8) != here[name]


@pytest.mark.slow
def test_a_fresh_process_gives_the_same_bytes(here: dict[str, str]) -> None:
    command = [sys.executable, "-c", ALONE]
    done = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True)
    assert done.stdout.split() == list(here.values())


@pytest.mark.slow
def test_a_pool_gives_the_same_bytes(here: dict[str, str]) -> None:
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        halves = list(pool.map(digests, [7, 7], [NAMES[1::2], NAMES[::2]]))
    assert halves[0] | halves[1] == here
