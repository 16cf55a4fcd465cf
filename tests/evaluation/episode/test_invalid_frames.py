"""An invalid camera frame ends the episode, and every command that drives warns of it."""

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from short_scenario import write_short

from vpf_sim import cli
from vpf_sim.api import filling
from vpf_sim.envs import camera
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, unscored
from vpf_sim.evaluation.steps import InvalidFrame
from vpf_sim.evaluation.sweeps.run_folder import read_lines

BREAKING = """
import numpy as np
from vpf_sim.envs import camera
from vpf_sim import Command

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


@pytest.mark.usefixtures("in_one_process")
@pytest.mark.parametrize(
    "command",
    [["drive", "short.toml"], ["sweep", "--scenario", "short.toml", "--seeds", "0:1", "--workers", "1"]],
    ids=["drive", "sweep"],
)
def test_a_broken_camera_prints_a_warning(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_short(tmp_path)
    (tmp_path / "breaking.py").write_text(BREAKING)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "breaking", raising=False)
    monkeypatch.setattr(camera, "Renderer", camera.Renderer)  # which the driver's module changes
    assert cli.run([*command, "--driver", "breaking:Driver", "--json", "--out", "run"]) == 1
    (record,) = read_lines(tmp_path / "run" / "episodes.jsonl")
    said = capsys.readouterr()
    assert f"vpf-sim: WARNING: {record['id']}: {SENTENCE}\n" in said.err
    json.loads(said.out)
    assert record["status"] == "invalid_frame"
    assert record["invalid_frame"] == {"frame": 19, "time_s": pytest.approx(19 / 60), "fault": "black"}


def record(number: int, **changes: Any) -> Record:
    invalid = InvalidFrame(frame=3, time_s=0.05, fault="stale")
    job = Job("town04", "clear", "vpf", number)
    return unscored(job, "invalid_frame", invalid).model_copy(update=changes)


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
