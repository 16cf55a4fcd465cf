"""`sweep --dry-run`: what would be driven, without driving or writing."""

import json
from pathlib import Path

import pytest
from short_scenario import write_short
from stored import record, store

from vpf_sim import cli
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import make_plan

GRID = ["sweep", "--dry-run", "--scenario", "short.toml", "--driver", "pid", "--driver", "neutral", "--seeds", "3:6"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_short(tmp_path)
    return tmp_path


def test_cells_and_episodes_are_printed_and_nothing_else_happens(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(GRID) == 0
    said = capsys.readouterr().out.splitlines()
    assert [line.split() for line in said[2:4]] == [
        ["short.toml", "clear", name, "3", "3:6"] for name in ("pid", "neutral")
    ]
    assert said[-1] == "6 episodes to drive in 2 cells; nothing was driven or written"
    assert [path.name for path in folder.iterdir()] == ["short.toml"]


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run([*GRID, "--weather", "rain", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["episodes"] == 6
    cell = {"scenario": "short.toml", "weather": "rain", "seeds": [3, 4, 5]}
    assert answer["cells"] == [{**cell, "driver": name} for name in ("pid", "neutral")]


def test_stored_episodes_are_left_out(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = make_plan(
        {"scenario": ["short.toml"], "weather": ["clear"], "driver": ["pid", "neutral"], "seeds": "3:6"}, "test"
    )
    store(folder / "run", plan, [record(Job("short.toml", "clear", "pid", seed)) for seed in (3, 5)])
    from vpf_sim.evaluation.sweeps.manifest import Manifest

    (folder / "run" / "manifest.json").write_text(json.dumps(Manifest.of("sweep", plan).as_json()))
    before = {path: path.read_bytes() for path in (folder / "run").iterdir()}
    assert cli.run([*GRID, "--out", "run", "--resume"]) == 0
    said = capsys.readouterr().out
    assert "4 episodes to drive in 2 cells, 2 are stored" in said
    assert {path: path.read_bytes() for path in (folder / "run").iterdir()} == before
