"""A full disk: stored data is kept, one line names the file, and the run can be resumed."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import recorded_layouts as layouts
from little_room import limited
from short_scenario import write_short
from systems import POSIX_ONLY

from vpf_sim import cli
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.sweeps.run_folder import JsonLines, read_lines

ROOM = 200  # bytes
FILM_ROOM = 60_000  # bytes, for tables and records, but not for a film


def test_a_line_that_does_not_fit_is_not_there_at_all(tmp_path: Path) -> None:
    lines = JsonLines(tmp_path / "episodes.jsonl")
    lines.append({"id": "a"})
    for room in (ROOM, len('{"id": "a"}\n')):  # for half of the line, and for none of it
        with limited(room), pytest.raises(OSError, match=r"episodes\.jsonl"):
            lines.append({"id": "b", "more": "x" * ROOM})
        assert (tmp_path / "episodes.jsonl").read_text() == '{"id": "a"}\n'
    lines.append({"id": "c"})
    lines.close()
    assert read_lines(tmp_path / "episodes.jsonl") == [{"id": "a"}, {"id": "c"}]


def test_a_step_table_that_does_not_fit_is_not_there_at_all(tmp_path: Path) -> None:
    table = StepTable(np.random.default_rng(0).normal(size=(50, len(Step._fields))))
    path = tmp_path / "steps" / "a.parquet"
    with limited(ROOM), pytest.raises(OSError, match=r"a\.parquet") as caught:
        steps.write(table, path)
    assert caught.value.strerror == "File too large"
    assert list(path.parent.iterdir()) == []


def sweep(folder: Path, out: Path, *more: str) -> list[str]:
    grid = ["--scenario", str(folder / "short.toml"), "--driver", "pid", "--driver", "neutral", "--seeds", "0:3"]
    return [sys.executable, "-m", "vpf_sim.cli", "sweep", *grid, "--workers", "1", "--out", str(out), *more]


def contents(out: Path) -> tuple[list[str], Any]:
    lines = sorted((out / "episodes.jsonl").read_text().splitlines())
    return lines, json.loads((out / "summary.json").read_text())


@POSIX_ONLY
@pytest.mark.slow
def test_a_sweep_on_a_full_disk_can_be_resumed(tmp_path: Path) -> None:
    write_short(tmp_path)
    subprocess.run(sweep(tmp_path, tmp_path / "whole"), check=True, capture_output=True)
    size = (tmp_path / "whole" / "episodes.jsonl").stat().st_size
    largest = max(path.stat().st_size for path in (tmp_path / "whole" / "steps").iterdir())
    room = max(size // 2, largest + 1)
    assert room < size, "the records, not the steps, are what runs out of room"
    out = tmp_path / "cramped"
    code = f"import os, resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, ({room}, {room})); "
    command = [sys.executable, "-c", code + "os.execv(sys.argv[1], sys.argv[1:])", *sweep(tmp_path, out)]
    done = subprocess.run(command, capture_output=True, text=True, env=dict(os.environ))
    lines = done.stderr.splitlines()
    stored = read_lines(out / "episodes.jsonl")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert lines[-3] == f"stopped with {len(stored)} of 6 episodes stored"
    assert lines[-2] == f"go on with: vpf-sim sweep --out {out} --resume --workers 1"
    assert lines[-1].startswith(f"vpf-sim: {out / 'episodes.jsonl'}: ")
    assert 0 < len(stored) < 6
    subprocess.run(sweep(tmp_path, out, "--resume"), check=True, capture_output=True)
    assert contents(out) == contents(tmp_path / "whole")


def test_a_video_on_a_full_disk_loses_only_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The record and the steps are stored, the answer is given, and a former film is still there."""
    film, out = tmp_path / "drive.mp4", tmp_path / "run"
    film.write_text("the former film")
    command = [
        "drive",
        str(write_short(tmp_path)),
        "--driver",
        "pid",
        "--out",
        str(out),
        "--video",
        str(film),
        "--json",
    ]
    with limited(FILM_ROOM):
        assert cli.run(command) == 2
    said = capsys.readouterr()
    assert said.err == f"vpf-sim: {film}: File too large\n"
    assert film.read_text() == "the former film"
    assert [path.name for path in tmp_path.glob("drive*")] == ["drive.mp4"], "no draft is left"
    (record,) = read_lines(out / "episodes.jsonl")
    assert record["status"] == "success"
    assert steps.read(out / "steps" / f"{record['id']}.parquet").rows.shape[0] == record["steps"] + 1
    assert json.loads(said.out)["states_sha256"] == record["states_sha256"]


def test_a_replay_on_a_full_disk_keeps_the_record_and_writes_the_video_later(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, drive = tmp_path / "run", layouts.general(tmp_path / "cam")
    noise = np.random.default_rng(0).integers(0, 256, (layouts.FRAMES, 128, 192, 3), dtype=np.uint8)
    layouts.video(drive / "drive.mp4", list(noise))
    command = ["replay", str(drive), "--driver", "neutral", "--out", str(out)]
    with limited(FILM_ROOM):
        assert cli.run(command) == 2
    film = out / "videos" / "my drive.mp4"
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "stopped with 1 of 1 drives stored"
    assert said[1] == f"go on with: vpf-sim {' '.join(command)} --resume"
    assert said[2:] == [f"vpf-sim: {film}: File too large"]
    before = (out / "replays.jsonl").read_bytes()
    assert b"my drive" in before
    assert not film.exists()
    assert cli.run([*command, "--resume"]) == 0
    assert (out / "replays.jsonl").read_bytes() == before
    assert film.stat().st_size > FILM_ROOM
