"""`runs/latest`: the run that began last, without a link."""

import os
from pathlib import Path

import pytest
from recorded_layouts import general
from stored import record, store

from vpf_sim import cli
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import make_plan
from vpf_sim.evaluation.sweeps.run_folder import located

PLAN = make_plan({"scenario": ["town04"], "weather": ["clear"], "driver": ["pid"], "seeds": "0:1"}, "test")


def run(path: Path, began_s: int) -> None:
    store(path, PLAN, [record(Job("town04", "clear", "pid", 0))])
    os.utime(path / "manifest.json", (began_s, began_s))


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three runs, the newest neither the first nor the last by name, and two folders that are no runs."""
    monkeypatch.chdir(tmp_path)
    for name, began_s in (("20260101-080000-sweep", 100), ("mine", 300), ("20260102-080000-drive", 200)):
        run(tmp_path / "runs" / name, began_s)
    (tmp_path / "runs" / "20270101-080000-gallery").mkdir()
    replay = tmp_path / "runs" / "20270101-080000-replay"
    replay.mkdir()
    (replay / "manifest.json").write_text("{}")
    return tmp_path / "runs"


@pytest.mark.usefixtures("runs")
def test_it_is_the_run_that_began_last() -> None:
    assert located(Path("runs/latest")) == Path("runs/mine")
    assert located(Path("runs/mine")) == Path("runs/mine")


def test_a_folder_of_this_name_is_itself(runs: Path) -> None:
    run(runs / "latest", 1)
    assert located(runs / "latest") == runs / "latest"


@pytest.mark.usefixtures("runs")
@pytest.mark.parametrize(
    "command", [["check", "runs/latest", "--rules", "rules.toml"], ["score", "runs/latest"], ["results", "runs/latest"]]
)
def test_commands_take_it(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    Path("rules.toml").write_text("[[rules]]\ncollisions_at_most = 0\n")
    code = cli.run(command)
    said = capsys.readouterr()
    assert "latest" not in said.out + said.err
    assert code == 0 or "runs/mine" in said.err


def test_without_a_run_it_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for command in (["report", "runs/latest"], ["video", "runs/latest", "--id", "a"]):
        assert cli.run(command) == 2
        assert capsys.readouterr().err == ("vpf-sim: runs/latest: expected a run folder, got nothing of that name\n")


@pytest.mark.parametrize("others", [False, True])
@pytest.mark.parametrize(
    "command",
    [["drive", "straight", "--driver", "neutral"], ["weathers", "gallery", "--weather", "clear"], ["replay", "cam"]],
)
def test_it_is_no_name_for_a_new_run(
    command: list[str],
    others: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    general(tmp_path / "cam")
    if others and command[0] != "replay":  # whose --resume may name it
        run(tmp_path / "runs" / "mine", 100)
    assert cli.run([*command, "--out", "runs/latest"]) == 2
    assert "runs/latest: expected another name" in capsys.readouterr().err
    assert not (tmp_path / "runs" / "latest").exists()
