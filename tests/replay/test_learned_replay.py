"""A learned driver on a recording: it is asked at its rate, whatever the recording's, and hashed for a resumption."""

from pathlib import Path

import policies
import pytest
import recorded_layouts as layouts

from vpf_sim import cli
from vpf_sim.evaluation import parquet


def test_a_policy_answers_each_frame_of_a_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drive, run = layouts.general(tmp_path / "cam"), tmp_path / "run"
    policy = policies.write(tmp_path, policies.constant(0.25, -0.5))
    command = ["replay", str(drive), "--driver", f"onnx:{policy}", "--no-video", "--out", str(run)]
    assert cli.run(command) == 0
    (table,) = (run / "frames").glob("*.parquet")
    commands = parquet.read(table, ("throttle", "steering"), "frames", "replay")
    assert len(commands) > 10
    assert (commands == [0.25, -0.5]).all()
    policies.write(tmp_path, policies.constant(0.5, 0.0))
    assert cli.run([*command, "--resume"]) == 2
    assert "drivers changed" in capsys.readouterr().err
