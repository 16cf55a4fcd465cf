"""What drivers of the user's own change of the process: nobody else finds it changed."""

import json
import os
import random
import subprocess
import sys
import warnings
from pathlib import Path

import cv2
import numpy as np
import pytest

from vpf_sim import drivers, process_state
from vpf_sim.evaluation.episode import episode

GOAL_M = 6.0  # a metre ahead
SCENARIO = f"""schema = 1
[road]
lanes = 3
lane_width_m = 3.5
segments = [{{kind = "line", length_m = 80}}]
[ego]
lane = 2
s_m = 5.0
speed_mps = 5.55
speed_reference_mps = 5.55
[goal]
s_m = {GOAL_M}
"""
DRIVERS = """import os, random, sys, warnings
import cv2, numpy as np
from vpf_sim import Command


class Restless:
    privileged, uses_images = "none", False

    def reset(self, setup):
        os.chdir("elsewhere")
        os.environ["MINE"] = "1"
        os.environ.pop("THEIRS", None)
        random.seed(1), np.random.seed(1), np.seterr(all="raise")
        warnings.simplefilter("error")
        cv2.setNumThreads(3)
        self.place = os.getcwd()

    def act(self, observation):
        assert os.getcwd() == self.place, "where it went, it stays"
        assert os.environ["MINE"] == "1"
        return Command(0.0, 0.0)


class Loud(Restless):
    def reset(self, setup):
        os.write(1, b"loading weights\\n")  # as a C++ library's log does
        print("ready")
        print("steady", file=sys.__stdout__)

    def act(self, observation):
        return Command(0.0, 0.0)
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "short.toml").write_text(SCENARIO)
    (tmp_path / "restless_drivers.py").write_text(DRIVERS)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("THEIRS", "1")
    return tmp_path


def state() -> list[object]:
    numbers = np.random.get_state()[1].tolist()  # type: ignore[index,call-overload,union-attr]  # noqa: NPY002
    return [
        os.getcwd(),
        dict(os.environ),
        random.getstate(),
        numbers,
        warnings.filters[:],
        np.geterr(),
        cv2.getNumThreads(),
    ]


def test_an_episode_leaves_the_process_as_it_was(place: Path) -> None:
    before = state()
    result = episode.run("short.toml", "clear", "restless_drivers:Restless", 0)
    assert result.record.succeeded, result.traceback
    assert state() == before
    assert Path.cwd() == place


def test_relative_names_mean_the_same_after_a_driver_has_gone_elsewhere(place: Path) -> None:
    with process_state.preserved():
        driver = drivers.create("restless_drivers:Restless")
        driver.reset(None)  # type: ignore[arg-type]
        assert Path.cwd() == place
        driver.act(None)  # type: ignore[arg-type]
        assert Path.cwd() == place
    assert os.environ["THEIRS"] == "1"


def vpf_sim(*arguments: str | bytes, where: Path, **variables: str) -> "subprocess.CompletedProcess[bytes]":
    command: list[str | bytes] = [sys.executable, "-m", "vpf_sim.cli", *arguments]
    return subprocess.run(command, capture_output=True, cwd=where, env={**os.environ, **variables}, check=False)


def test_with_json_stdout_holds_one_object_whatever_a_driver_writes(place: Path) -> None:
    done = vpf_sim("drive", "short.toml", "--driver", "restless_drivers:Loud", "--json", "--out", "run", where=place)
    assert done.returncode == 0, done.stderr.decode()
    assert json.loads(done.stdout)["status"] == "success"
    for word in (b"loading weights", b"ready", b"steady"):
        assert word in done.stderr


def test_an_output_that_takes_ascii_gets_escapes(place: Path) -> None:
    done = vpf_sim("weathers", "list", where=place, PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.isascii()


def test_a_reader_that_has_gone_changes_no_exit_code(place: Path) -> None:
    command = [sys.executable, "-m", "vpf_sim.cli", "weathers", "list"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=place) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


@pytest.mark.skipif(os.name != "posix", reason="names are bytes on POSIX only")
@pytest.mark.parametrize("option", [b"--driver", b"--out"])
def test_a_name_that_is_no_utf8_is_refused_in_one_line(option: bytes, place: Path) -> None:
    done = vpf_sim(b"sweep", option, b"stra\xdfe", where=place)
    assert done.returncode == 2
    assert done.stderr == b"vpf-sim: expected names in UTF-8, got 'stra\\udcdfe'; rename the file or folder\n"
