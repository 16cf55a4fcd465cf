"""A learned driver on a recording: a command for each frame, a hash to resume, warnings about unfamiliar inputs."""

import json
from dataclasses import asdict
from pathlib import Path

import policies
import pytest
import recorded_layouts as layouts

from vpf_sim import cli
from vpf_sim.drivers.learned.driver import shrink
from vpf_sim.drivers.learned.familiarity import learned_from
from vpf_sim.drivers.learned.manifest import PictureInput
from vpf_sim.evaluation import parquet

WHOLE = PictureInput(width_px=8, height_px=6)


def test_a_policy_gives_a_command_for_each_frame(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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


@pytest.mark.parametrize("is_like", [True, False])
def test_full_braking_and_unlike_inputs_are_warned_of(
    is_like: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The drive is at 8 to 10 m/s, of noisy pictures; the other policy knows dark ones at 20 km/h."""
    drive, run = layouts.general(tmp_path / "cam"), tmp_path / "run"
    shown = [shrink(layouts.picture(k), WHOLE) for k in range(24)]
    known = learned_from(shown if is_like else [shade // 8 for shade in shown], [8.0, 11.0] if is_like else [0.0, 5.6])
    manifest = f"{policies.MANIFEST}[learned_from]\n" + "".join(
        f"{key} = {json.dumps(value)}\n" for key, value in asdict(known).items()
    )
    policy = policies.write(tmp_path, policies.constant(-1.0, 0.0), manifest)
    command = ["replay", str(drive), "--driver", f"onnx:{policy}", "--no-video", "--out", str(run)]
    assert cli.run(command) == 0
    printed = capsys.readouterr().out
    assert "the driver brakes fully in 100 % of the frames" in printed
    assert ("the picture is unlike" in printed) != is_like
    assert ("outside of the 0.0 to 5.6 m/s" in printed) != is_like
    assert ("the picture is unlike" in (run / "report.html").read_text()) != is_like
