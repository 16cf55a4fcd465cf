"""An invalid camera frame ends the episode, and every command that drives warns of it."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from short_scenario import write_short

from vpf_sim.api import filling
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.scoring import failed
from vpf_sim.evaluation.outcome import InvalidFrame
from vpf_sim.evaluation.sweeps.json_lines import read_lines

BREAKING = """
import numpy as np
from vpf_sim.envs import camera
from vpf_sim.types import Command

class Broken(camera.Renderer):
    def render(self, ego, time_s):
        frame = super().render(ego, time_s)
        return np.zeros_like(frame) if time_s > 0.3 else frame

camera.Renderer = Broken

class Driver:
    privileged = "none"
    def reset(self, setup): pass
    def act(self, observation): return Command(0.0, 0.0)
"""
SENTENCE = "invalid frame 19, at 0.317 s: all black"


def vpf_sim(folder: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "vpf_sim.cli", *arguments, "--driver", "breaking:Driver", "--json", "--out", "run"]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=dict(os.environ), check=False)


@pytest.mark.parametrize(
    "command",
    [["drive", "short.toml"], ["sweep", "--scenario", "short.toml", "--seeds", "0:1", "--workers", "1"]],
    ids=["drive", "sweep"],
)
def test_a_broken_camera_prints_a_warning(command: list[str], tmp_path: Path) -> None:
    write_short(tmp_path)
    (tmp_path / "breaking.py").write_text(BREAKING)
    done = vpf_sim(tmp_path, *command)
    (record,) = read_lines(tmp_path / "run" / "episodes.jsonl")
    assert done.returncode == 1
    assert f"vpf-sim: WARNING: {record['id']}: {SENTENCE}\n" in done.stderr
    json.loads(done.stdout)
    assert record["status"] == "invalid_frame"
    assert record["invalid_frame"] == {"frame": 19, "time_s": pytest.approx(19 / 60), "fault": "black"}


def record(number: int, **changes: Any) -> Record:
    invalid = InvalidFrame(frame=3, time_s=0.05, fault="stale")
    job = Job("town04", "clear", "vpf", number)
    return failed(job, "invalid_frame", invalid).model_copy(update=changes)


def test_only_invalid_frames_are_warned_of(capsys: pytest.CaptureFixture[str]) -> None:
    filling.warn([record(1, status="success", invalid_frame=None), record(2, status="error")])
    assert capsys.readouterr().err == ""


def test_many_warnings_are_counted(capsys: pytest.CaptureFixture[str]) -> None:
    filling.warn(record(number) for number in range(filling.MOST + 5))
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == filling.MOST + 2
    assert lines[0].startswith(
        "vpf-sim: WARNING: town04.clear.vpf.0: invalid frame 3, at 0.050 s: the same as the one before"
    )
    assert lines[-2] == "vpf-sim: WARNING: and 5 more episodes with an invalid frame"
