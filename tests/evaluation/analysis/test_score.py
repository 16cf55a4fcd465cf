"""Rescoring from stored steps, and one-line errors for an incomplete or foreign folder."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from driven_run import drive_run
from short_scenario import write_short

from vpf_sim import cli
from vpf_sim.errors import InputError
from vpf_sim.evaluation import parquet, steps
from vpf_sim.evaluation.analysis import rescore
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics import collision
from vpf_sim.evaluation.sweeps.manifest import read_manifest
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder, read_lines


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two drivers and two seeds, one of whose episodes ended by a worker's death."""
    root = tmp_path_factory.mktemp("score")
    plan = Plan((str(write_short(root)),), ("clear",), ("pid", "neutral"), "3:5")
    return drive_run(root / "run", plan, lost=1)


@pytest.fixture
def run(driven: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(driven, tmp_path / "run"))


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def no_world(*_: Any, **__: Any) -> None:
    raise AssertionError("a world was built")


def test_rescoring_an_unchanged_run_changes_nothing_and_drives_nothing(
    run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("vpf_sim.envs.four_lane.FourLane.__init__", no_world)
    before = files(run)
    assert cli.run(["score", str(run), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["scored"], answer["changed"]) == (4, [])
    assert files(run) == before, "byte by byte"
    assert answer["rows"] == json.loads((run / "summary.json").read_text())["rows"]
    assert cli.run(["score", str(run)]) == 0
    assert "4 of 4 planned episodes rescored, 0 changed" in capsys.readouterr().out


def test_stage_times_are_in_the_timing_and_not_in_the_records(run: Path) -> None:
    stages = read_lines(run / "timing.jsonl")[0]["stages_ms"]
    whole, parts = {"world", "driver", "log"}, {"physics", "ending", "observation", "info"}
    assert stages.keys() == whole | parts, "no frame is taken for who looks at none"
    assert all(value > 0.0 for value in stages.values())
    assert "stages_ms" not in (run / "episodes.jsonl").read_text()


def test_every_record_follows_from_its_steps(run: Path) -> None:
    stored = read_lines(run / "episodes.jsonl")
    assert [record["steps"] > 0 for record in stored] == [True, True, True, False]
    spoilt = [{**record, "path_mse_m2": 9.0, "comfort": None} for record in stored]
    (run / "episodes.jsonl").write_text("".join(json.dumps(record) + "\n" for record in spoilt))
    found = rescore.rescore(run)
    assert found.changed == {record["id"]: ["comfort", "path_mse_m2"] for record in stored[:3]}
    assert read_lines(run / "episodes.jsonl")[:3] == stored[:3]


def test_a_changed_formula_is_stored_and_marked_with_the_code_that_made_it(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = read_lines(run / "episodes.jsonl")
    monkeypatch.setattr(collision, "driving_score_2_0", lambda *_: 0.25)
    monkeypatch.setattr(rescore, "fingerprint", lambda: {"source": "newer"})
    assert set(map(tuple, rescore.rescore(run).changed.values())) == {("driving_score_2_0",)}
    after = read_lines(run / "episodes.jsonl")
    mark = after[0]["fingerprint"]
    assert after[:3] == [{**record, "driving_score_2_0": 0.25, "fingerprint": mark} for record in before[:3]]
    assert after[3] == before[3], "nothing was scored, nothing is marked"
    assert json.loads((run / "summary.json").read_text())["rows"][1]["driving_score_2_0"] == 0.25
    assert rescore.rescore(run).changed == {}, "the mark alone is no change"


def test_an_unfinished_run_has_no_summary(run: Path) -> None:
    (run / "summary.json").unlink()
    lines = (run / "episodes.jsonl").read_text().splitlines(keepends=True)
    (run / "episodes.jsonl").write_text("".join(lines[:2]) + '{"id": "torn')
    found = rescore.rescore(run)
    assert (len(found.records), found.planned) == (2, 4)
    assert [row.episodes for row in found.summary.rows] == [2, 2]
    assert not (run / "summary.json").exists()


def edit(change: Callable[[dict[str, Any]], Any]) -> Callable[[Path], None]:
    """A change of the first record."""

    def spoil(run: Path) -> None:
        first, *others = read_lines(run / "episodes.jsonl")
        change(first)
        (run / "episodes.jsonl").write_text("".join(json.dumps(record) + "\n" for record in [first, *others]))

    return spoil


def first_steps(run: Path) -> Path:
    return run / "steps" / f"{read_lines(run / 'episodes.jsonl')[0]['id']}.parquet"


def cut(run: Path) -> None:
    path = first_steps(run)
    path.write_bytes(path.read_bytes()[:-100])


def swap(run: Path) -> None:
    one, other, *_ = sorted((run / "steps").iterdir())
    one.write_bytes(other.read_bytes())
    other.write_bytes(one.read_bytes())


def other_table(run: Path) -> None:
    parquet.write(np.arange(3.0)[:, None], ["time_s"], first_steps(run))


def other_scenario(run: Path) -> None:
    path = run / "manifest.json"
    requested = json.loads(path.read_text())
    requested["scenarios"] = dict.fromkeys(requested["scenarios"], "0123abcd")
    path.write_text(json.dumps(requested))


def another_seed(record: dict[str, Any]) -> None:
    cell, _, _ = record["id"].rpartition(".")
    record.update(id=f"{cell}.99", seed=99)


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (cut, "expected a step table of this version, got: "),
        (lambda run: first_steps(run).unlink(), "expected the steps of an episode, found nothing"),
        (lambda run: first_steps(run).write_text("x"), "expected a step table of this version, got: "),
        (other_table, "of this version, got: no column x_m"),
        (swap, "of the record, got "),
        (edit(lambda record: record.pop("status")), "key 'status' is missing"),
        (edit(lambda record: record.update(id="x")), 'episodes.jsonl: "x": expected the id of its scenario, weather'),
        (edit(another_seed), ".pid.99: expected an episode of the plan"),
        (edit(lambda record: record.pop("id")), "expected a record with an id on each line"),
        (other_scenario, "changed since the run: was 0123abcd, is "),
        (lambda run: (run / "manifest.json").unlink(), "manifest.json: expected the manifest of a run"),
        (lambda run: (run / "manifest.json").write_text("[]"), "manifest.json: expected a table for plan"),
        (shutil.rmtree, "manifest.json: expected the manifest of a run"),
    ],
)
def test_an_incomplete_or_foreign_folder_is_one_clear_line(
    spoil: Callable[[Path], Any], sentence: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil(run)
    before = files(run) if run.exists() else {}
    assert cli.run(["score", str(run)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert sentence in said.err
    assert said.err.count("\n") == 1
    assert (files(run) if run.exists() else {}) == before, "it is left as it was"


def test_a_running_sweep_is_not_rescored(run: Path) -> None:
    folder = RunFolder(run, read_manifest(run), resume=True)
    with pytest.raises(InputError, match="in use by another run"):
        rescore.rescore(run)
    folder.close()


def test_the_route_is_that_of_the_seed() -> None:
    """A record of a scenario that draws its road scores on the road that was drawn."""
    from vpf_sim.envs.four_lane import FourLane

    env = FourLane("random")
    env.reset(seed=8)
    along = np.arange(0.0, 40.0, 0.1)
    x, y = (np.interp(along, np.arange(len(env.route)), env.route[:, axis]) for axis in (0, 1))
    table = steps.StepTable.of(
        [steps.Step(s, *at, 0.0, 1.0, 0.0, s, 0.0, np.inf) for s, *at in zip(along, x, y, strict=True)]
    )
    record = rescore.score(Job("random", "clear", "pid", 8), rescore.Outcome("timeout", table, None, "")).as_json()
    assert record["path_mse_m2"] == pytest.approx(0.0, abs=1e-12)
    assert record["route_completion"] == pytest.approx(along[-1] / env.route_length_m)
