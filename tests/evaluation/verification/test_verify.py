"""A verification finds planted frauds, and passes honest runs."""

import json
import shutil
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from one_process import one_process
from short_scenario import write_short
from weighted_driver import WEIGHT

import vpf_sim
from vpf_sim import cli
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.analysis.rescore import rescore
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.verification import again

NAME, DRIVER, SEEDS = "short.toml", "weighted_driver:Weighted", "0:3"
JOBS = [Job(NAME, "clear", DRIVER, seed) for seed in range(3)]


def sweep(out: Path) -> None:
    vpf_sim.sweep(NAME, driver=DRIVER, seeds=SEEDS, out=out, workers=1, progress=False)


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of a driver with one weight: seeds 0 and 2 arrive, seed 1 starts beside the road and leaves it."""
    root = tmp_path_factory.mktemp("project")
    write_short(root, goal_m=6.0)
    with pytest.MonkeyPatch.context() as patch, one_process():
        patch.chdir(root)
        sweep(root / "run")
        patch.setenv(WEIGHT, "0.02")
        sweep(root / "other weights")
    return root


@pytest.fixture
def run(honest: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the run that may be changed, opened from a folder that has none of its files."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    return Path(shutil.copytree(honest / "run", tmp_path / "run"))


def verified(run: Path, capsys: pytest.CaptureFixture[str], *more: str) -> dict[str, Any]:
    """The answer of the command, whose exit code says the same."""
    code = cli.run(["verify", str(run), "--json", "--workers", "1", *more])
    answer: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert code == int(not answer["ok"])
    return answer


def edited(run: Path, job: Job, change: Callable[[dict[str, Any]], object]) -> None:
    """Change the record of an episode in its file."""
    file = run / "episodes.jsonl"
    rows = [json.loads(line) for line in file.read_text("utf-8").splitlines()]
    for row in rows:
        if row["id"] == job.id:
            change(row)
    file.write_text("".join(json.dumps(row) + "\n" for row in rows), "utf-8")


def test_an_honest_run_is_verified_wherever_it_lies(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = verified(run, capsys, "--share", "1")
    assert answer["ok"]
    assert answer["driven"] == sorted(job.id for job in JOBS)
    assert cli.run(["verify", str(run), "--share", "0"]) == 0
    said = capsys.readouterr().out
    assert "3 planned episodes, all stored" in said
    assert said.endswith("verified\n")


@pytest.mark.usefixtures("in_one_process")
def test_a_run_that_compares_drivers_is_verified_in_any_order_of_theirs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_short(tmp_path)
    vpf_sim.sweep(NAME, driver=["stanley", "neutral"], seeds=SEEDS, out=tmp_path / "run", workers=1, progress=False)
    (comparison,) = json.loads((tmp_path / "run" / "summary.json").read_text())["comparisons"]
    assert (comparison["driver"], comparison["minus"]) == ("stanley", "neutral")
    assert verified(tmp_path / "run", capsys, "--share", "0.5")["ok"]


def test_an_edited_record_is_found(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = json.loads((run / "episodes.jsonl").read_text().splitlines()[0])["path_mse_m2"]
    edited(run, JOBS[0], lambda row: row.update(path_mse_m2=0.001))
    found = verified(run, capsys, "--share", "0")["mismatch"]
    assert (found["episode"], found["quantity"], found["stored"]) == (JOBS[0].id, "path_mse_m2", 0.001)
    assert found["found"] == pytest.approx(before, abs=1.0)
    assert "edited record" in found["cause"]


def test_a_loss_that_is_called_a_success_is_found(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The record, its scores and the summary agree, since they were made again; its steps end on the way."""
    file = run / "steps" / f"{JOBS[1].id}.parquet"
    table = steps.read(file)
    short = steps.StepTable(table.rows[: len(table.rows) // 2])
    steps.write(short, file)
    states = sha256(short.states()).hexdigest()
    edited(run, JOBS[1], lambda row: row.update(status="success", states_sha256=states, steps=len(short)))
    rescore(run)
    found = verified(run, capsys, "--share", "0")["mismatch"]
    assert (found["episode"], found["quantity"], found["stored"]) == (JOBS[1].id, "status", "success")
    assert found["found"].endswith("of the route")


@pytest.mark.usefixtures("in_one_process")
def test_an_episode_driven_with_other_weights_is_found(
    honest: Path, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = honest / "other weights"
    name = f"{JOBS[2].id}.parquet"
    shutil.copy(other / "steps" / name, run / "steps" / name)
    rows = {row["id"]: row for row in map(json.loads, (other / "episodes.jsonl").read_text().splitlines())}
    edited(run, JOBS[2], lambda row: (row.clear(), row.update(rows[JOBS[2].id])))
    rescore(run)
    assert verified(run, capsys, "--share", "0")["ok"], "it contradicts nothing in the folder"
    found = verified(run, capsys, "--share", "1")["mismatch"]
    assert (found["episode"], found["step"], found["quantity"]) == (JOBS[2].id, 1, "steering")
    assert found["stored"] == pytest.approx(2.0 * found["found"])
    assert "other weights" in found["cause"]


def test_a_score_typed_into_the_summary_is_found(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    summary = json.loads((run / "summary.json").read_text())
    summary["rows"][0]["driving_score_2_1"] = 0.999
    (run / "summary.json").write_text(json.dumps(summary))
    found = verified(run, capsys, "--share", "0")["mismatch"]
    assert found["quantity"].endswith("driving_score_2_1")
    assert (found["stored"], found["cause"]) == (0.999, "an edited summary")


def test_failures_left_out_are_found(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = run / "episodes.jsonl"
    lines = [line for line in file.read_text().splitlines(keepends=True) if json.loads(line)["id"] != JOBS[1].id]
    file.write_text("".join(lines))
    (run / "summary.json").unlink()
    assert cli.run(["verify", str(run)]) == 1
    said = capsys.readouterr().out
    assert said.startswith(f"NOT VERIFIED: {JOBS[1].id}: records of a planned episode: stored 0, found 1\n")
    assert "left out" in said


def test_a_record_that_stands_twice_or_is_not_planned_is_found(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = run / "episodes.jsonl"
    text = file.read_text()
    stranger = json.loads(text.splitlines()[0])
    stranger |= {"seed": 9, "id": Job(NAME, "clear", DRIVER, 9).id}
    file.write_text(text + json.dumps(stranger) + "\n")
    assert verified(run, capsys, "--share", "0")["mismatch"]["episode"] == stranger["id"]


@pytest.mark.usefixtures("in_one_process")
def test_edited_steps_with_hashes_made_again_are_found(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = run / "steps" / f"{JOBS[0].id}.parquet"
    table = steps.read(file)
    moved = table.replaced({"y_m": table.y_m + np.where(np.arange(len(table.rows)) >= 5, 1e-9, 0.0)})
    steps.write(moved, file)
    states = sha256(moved.states()).hexdigest()
    edited(run, JOBS[0], lambda row: row.update(states_sha256=states))
    rescore(run)
    found = verified(run, capsys, "--share", "1")["mismatch"]
    assert (found["episode"], found["step"], found["quantity"]) == (JOBS[0].id, 5, "y_m")
    assert "edited" in found["cause"]


@pytest.mark.usefixtures("in_one_process")
def test_another_version_is_named_as_the_cause(honest: Path, run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["fingerprint"]["source"] = 64 * "0"
    (run / "manifest.json").write_text(json.dumps(manifest))
    assert verified(run, capsys, "--share", "1")["ok"], "another version may drive the same"
    shutil.copy(honest / "other weights" / "episodes.jsonl", run / "episodes.jsonl")
    shutil.copytree(honest / "other weights" / "steps", run / "steps", dirs_exist_ok=True)
    shutil.copy(honest / "other weights" / "summary.json", run / "summary.json")
    assert verified(run, capsys, "--share", "1")["mismatch"]["cause"].startswith("another version of vpf_sim: source")


def test_an_edited_scenario_is_found(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = run / "inputs.json"
    file.write_text(file.read_text().replace("80", "60"))
    found = verified(run, capsys, "--share", "0")["mismatch"]
    assert found["quantity"] == f"scenario {NAME}"


@pytest.mark.usefixtures("in_one_process")
def test_without_steps_every_episode_is_to_be_driven_again(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.rmtree(run / "steps")
    found = verified(run, capsys, "--seed", "1")["mismatch"]
    assert found["quantity"] == "steps"
    assert "--share 1" in found["cause"]
    assert verified(run, capsys, "--share", "1")["ok"]
    edited(run, JOBS[0], lambda row: row.update(path_mse_m2=0.001))
    (run / "summary.json").unlink()
    found = verified(run, capsys, "--share", "1")["mismatch"]
    assert (found["episode"], found["quantity"], found["stored"]) == (JOBS[0].id, "path_mse_m2", 0.001)


def test_the_answer_names_the_records_that_it_is_of(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = verified(run, capsys, "--share", "0")["records_sha256"]
    assert before == sha256((run / "episodes.jsonl").read_bytes()).hexdigest()
    edited(run, JOBS[0], lambda row: row.update(path_mse_m2=0.001))
    assert verified(run, capsys, "--share", "0")["records_sha256"] != before


def test_the_sample_is_that_of_its_seed_and_has_one_episode_at_least() -> None:
    jobs = [Job("a", "clear", "pid", seed) for seed in range(100)]
    assert len(again.sample(jobs, 0.05, 7)) == 5
    assert again.sample(jobs, 0.05, 7) == again.sample(jobs, 0.05, 7) != again.sample(jobs, 0.05, 8)
    assert len(again.sample(jobs[:3], 0.05, 7)) == 1
    assert again.sample(jobs, 1.0, 7) == jobs
    by_hand = [Job("a", "clear", "keyboard", seed) for seed in range(3)]
    assert again.sample([*by_hand, *jobs], 1.0, 7) == jobs, "nobody is asked to drive again"
    assert again.sample(by_hand, 1.0, 7) == []


@pytest.mark.parametrize("share", ["-0.1", "1.5", "nan"])
def test_a_share_is_between_0_and_1(share: str, run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["verify", str(run), "--share", share]) == 2
    assert "--share: expected 0 to 1" in capsys.readouterr().err
