"""The Rerun recording of a drive, read back by Rerun's own tool."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from short_scenario import write_short

from vpf_sim import cli

ENTITIES = {
    "/camera",
    "/camera/flow",
    "/camera/foe",
    "/camera/obstacle_map",
    "/cost",
    "/scene/obstacles",
    "/scene/edges",
    "/scene/ego",
    *(f"/scene/force/{name}" for name in ("target", "obstacle", "road", "total")),
    *(f"/signals/{name}" for name in ("throttle", "steering", "pid_throttle", "pid_steering", "speed_mps")),
    "/trajectory",
}


def entities(path: Path, home: Path) -> set[str]:
    """The entity paths in a recording."""
    command = [sys.executable, "-m", "rerun", "rrd", "print", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, "HOME": str(home)})
    return set(re.findall(r"(/[a-z_/]+)", done.stdout))


@pytest.fixture
def short(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    return str(write_short(tmp_path))


def drive(short: str, driver: str, file: str) -> int:
    return cli.run(["drive", short, "--driver", driver, "--out", "run", "--rerun", file])


def test_a_drive_is_recorded_with_frames_fields_scene_and_signals(short: str, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="the extra `viewer` is not installed")
    assert drive(short, "vpf", "new/drive.rrd") == 0
    assert entities(tmp_path / "new" / "drive.rrd", tmp_path) >= ENTITIES


def test_a_driver_without_a_plan_leaves_frames_and_signals(short: str, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="the extra `viewer` is not installed")
    assert drive(short, "pid", "drive.rrd") == 0
    found = entities(tmp_path / "drive.rrd", tmp_path)
    assert found >= {"/camera", "/signals/throttle", "/trajectory"}
    assert not found & {"/camera/flow", "/scene/ego", "/cost"}


def test_without_the_sdk_one_line_says_how_to_install_it(
    short: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert drive(short, "pid", "drive.rrd") == 2
    expected = "vpf-sim: --rerun: expected the Rerun SDK, which is not installed: pip install 'vpf_sim[viewer]'\n"
    assert capsys.readouterr().err == expected
    assert [entry.name for entry in tmp_path.iterdir()] == ["short.toml"]


def test_a_file_that_cannot_be_written_is_one_line(
    short: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rerun", reason="the extra `viewer` is not installed")
    (tmp_path / "folder.rrd").mkdir()
    assert drive(short, "pid", "folder.rrd") == 2
    said = capsys.readouterr().err
    assert said == "vpf-sim: --rerun: folder.rrd: expected a file that can be written, got: Is a directory\n"
    assert not (tmp_path / "run").exists()
