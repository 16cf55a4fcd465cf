"""Sweeps: equal records for any number of workers, and after any interruption."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from one_process import one_process
from short_scenario import write_short
from systems import POSIX_ONLY

from vpf_sim import cli
from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.statistics import seeds_for_mean, seeds_for_share, share_interval
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, read_record
from vpf_sim.evaluation.sweeps.manifest import Manifest
from vpf_sim.evaluation.sweeps.plan import Plan, make_plan, read_plan
from vpf_sim.evaluation.sweeps.run_folder import read_lines
from vpf_sim.evaluation.sweeps.sweep import changes, drive_and_store

DRIVERS = ("pid", "neutral")
SEEDS = "0:3"


def command(folder: Path, out: Path, *more: str) -> list[str]:
    """The arguments of a sweep."""
    grid = ["--scenario", str(folder / "short.toml"), "--driver", "pid", "--driver", "neutral", "--seeds", SEEDS]
    return ["sweep", *grid, "--out", str(out), *more]


def in_process(arguments: list[str]) -> list[str]:
    """The command for a process of its own, one that can be killed."""
    return [sys.executable, "-m", "vpf_sim.cli", *arguments]


def contents(out: Path) -> tuple[list[str], Any]:
    """What must not depend on how it came about."""
    return sorted((out / "episodes.jsonl").read_text().splitlines()), json.loads((out / "summary.json").read_text())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_short(tmp_path_factory.mktemp("sweep")).parent


@pytest.fixture(scope="module")
def undisturbed(folder: Path) -> Path:
    """A sweep in this process, to its end."""
    with one_process():
        assert cli.run(command(folder, folder / "serial")) == 0
    return folder / "serial"


def wait_for(out: Path, records: int) -> None:
    """Until a running sweep has stored so many."""
    give_up = time.monotonic() + 240.0
    while len(read_lines(out / "episodes.jsonl")) < records:
        assert time.monotonic() < give_up, "the sweep stores no records"
        time.sleep(0.02)


def test_a_run_folder_has_plan_and_results(undisturbed: Path) -> None:
    records = read_lines(undisturbed / "episodes.jsonl")
    manifest = json.loads((undisturbed / "manifest.json").read_text())
    assert len(records) == len({record["id"] for record in records}) == 6
    assert {record["status"] for record in records} == {"success"}
    assert manifest["plan"]["driver"] == list(DRIVERS)
    assert manifest["plan"]["seeds"] == SEEDS
    assert manifest["fingerprint"].keys() >= {"python", "numpy", "opencv", "opencv_cpu_features", "vpf_sim"}
    timing = {row["id"]: row for row in read_lines(undisturbed / "timing.jsonl")}
    assert timing.keys() == {record["id"] for record in records}
    assert all(row.keys() >= {"wall_s", "steps_per_s", "host", "worker", "retries"} for row in timing.values())
    assert {path.stem for path in (undisturbed / "steps").iterdir()} == timing.keys()


def test_a_killed_sweep_of_two_workers_resumes_to_the_records_of_one(folder: Path, undisturbed: Path) -> None:
    out = folder / "killed"
    killed = in_process(command(folder, out, "--workers", "2"))
    with subprocess.Popen(killed, stderr=subprocess.DEVNULL) as parent:
        wait_for(out, records=2)
        parent.kill()
    stored = read_lines(out / "episodes.jsonl")
    assert 2 <= len(stored) < 6
    with (out / "episodes.jsonl").open("a") as file:
        file.write('{"accuracy": {"sha')  # the line that was being written
    with one_process():
        assert cli.run(command(folder, out, "--resume")) == 0
    assert contents(out) == contents(undisturbed)


def listen_to_ctrl_c() -> None:
    """Of tests that a shell runs in the background, it is ignored, and so it would be by the sweep."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@POSIX_ONLY
def test_ctrl_c_stops_and_prints_the_resume_command(
    folder: Path, undisturbed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = folder / "stopped"
    stopped = in_process(command(folder, out, "--workers", "1"))
    with subprocess.Popen(stopped, stderr=subprocess.PIPE, text=True, preexec_fn=listen_to_ctrl_c) as parent:
        wait_for(out, records=1)
        os.kill(parent.pid, signal.SIGINT)
        _, said = parent.communicate()
    assert parent.returncode == 130
    assert "Traceback" not in said
    go_on = ["sweep", "--out", str(out), "--resume", "--workers", "1"]
    assert f"go on with: vpf-sim {' '.join(go_on)}\n" in said
    with one_process():
        assert cli.run([*go_on, "--json"]) == 0
    assert contents(out) == contents(undisturbed)
    assert json.loads(capsys.readouterr().out)["rows"] == json.loads((out / "summary.json").read_text())["rows"]


def test_an_edit_during_a_sweep_stops_it(tmp_path: Path) -> None:
    path = write_short(tmp_path)
    plan = Plan((str(path),), ("clear",), ("pid",), "0:1")
    requested, (job,) = Manifest.of("sweep", plan), plan.jobs()
    assert list(changes(requested, job)) == []
    other = requested.model_copy(update={"fingerprint": {**requested.fingerprint, "source": "as it was"}})
    with pytest.raises(InputError, match="source: changed while the sweep was running"):
        drive_and_store(tmp_path, None, other, job)
    path.write_text(path.read_text().replace("11.0", "12.0"))
    with pytest.raises(InputError, match=r"short\.toml: changed while the sweep was running"):
        drive_and_store(tmp_path, None, requested, job)
    assert not (tmp_path / "steps").exists()


def test_a_plan_is_its_grid_seed_by_seed() -> None:
    plan = Plan(("a", "b"), ("clear",), ("pid",), "4:6")
    assert [(job.scenario, job.seed) for job in plan.jobs()] == [("a", 4), ("b", 4), ("a", 5), ("b", 5)]
    assert len(Plan(("a", "a"), ("clear",), ("pid",), "4:6").jobs()) == 2


def test_a_plan_of_a_table() -> None:
    table = {"scenario": ["a"], "weather": ["clear"], "driver": ["pid"], "seeds": "0:1"}
    assert make_plan(table, "sweep.toml") == Plan(("a",), ("clear",), ("pid",), "0:1")


def test_the_plan_hard_comes_along(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = make_plan(read_plan("hard"), "hard")
    assert len(plan.jobs()) == 99
    assert len(plan.check()["scenarios"]) == len(plan.scenario)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hard").write_text('driver = ["pid"]', "utf-8")
    assert read_plan("./hard") == {"driver": ["pid"]}, "a path is a file"


def test_a_plan_of_single_drives_has_no_others() -> None:
    table = {"driver": ["pid", "vpf"], "drives": [["a", "rain", 9], ["b", "clear", 4]]}
    plan = make_plan(table, "sweep.toml")
    assert plan.jobs() == [Job(*place, driver, seed) for *place, seed in table["drives"] for driver in table["driver"]]
    assert (plan.scenario, plan.weather, plan.seeds) == (("a", "b"), ("rain", "clear"), "4:10"), "the grid about them"
    assert make_plan(json.loads(json.dumps(asdict(plan))), "manifest.json") == plan


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"drives": []}, "drives: expected at least one, got none"),
        ({"drives": [["a", "rain"]]}, "drives[0][2]: expected a value, got none"),
        ({"drives": [["a", "rain", "9"]]}, "drives[0][2]: expected an integer, got '9'"),
        ({"drives": [["a", "rain", -1]]}, "drives[0][2]: expected >= 0, got -1"),
        ({"seeds": "0:3"}, "seeds: expected drives or a grid, got both"),
    ],
)
def test_wrong_drives_of_a_plan_are_reported(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        make_plan({"driver": ["pid"], "drives": [["a", "rain", 9]], **changes}, "sweep.toml")
    assert str(caught.value) == f"sweep.toml: {sentence}"


def record(seed: int, status: str, mse: float, throttle: float | None) -> Record:
    accuracy = {"shadow": {"throttle": {"range": throttle}}}
    hit = int(status == "collision")
    rest = {"max_lane_offset_m": 0.0, "min_clearance_m": mse, "accuracy": accuracy, "perception": None, "comfort": None}
    rest |= {"path_mse_parts_m2": {"passing": None, "clear_of_obstacles": mse}}
    rest |= {"chattering": {"steering": {"direction_changes_per_s": mse}}, "collisions": hit, "at_fault_collisions": 0}
    scores = {"route_completion": 0.5, "driving_score_2_0": 0.5, "driving_score_2_1": 0.25, "path_mse_m2": mse}
    names = {"id": f"a.clear.pid.{seed}", "scenario": "a", "weather": "clear", "driver": "pid", "seed": seed}
    return read_record({**names, "status": status, "steps": 10, **scores, **rest}, "a line")


def test_means_are_over_successful_and_rates_over_planned_episodes() -> None:
    records = [record(0, "success", 1.0, 0.5), record(1, "collision", 9.0, 0.1), record(2, "success", 3.0, None)]
    (found,) = summarize(Plan(("a",), ("clear",), ("pid",), "0:4").jobs(), records).rows
    row: Any = found.as_json()
    assert (row["episodes"], row["successes"], row["statuses"]) == (4, 2, {"success": 2, "collision": 1})
    assert (row["driver"], row["privileged"]) == ("pid", "route")
    assert row["path_mse_m2"] == 2.0
    assert row["least_clearance_m"] == 1.0
    assert row["accuracy"]["shadow"]["throttle"]["range"] == 0.5
    assert (row["collisions"], row["at_fault_collisions"]) == (1, 0)
    assert row["chattering"]["steering"]["direction_changes_per_s"] == 2.0
    assert row["unsuccessful"]["path_mse_m2"] == 9.0
    assert row["driving_score_2_1"] == 0.25
    assert row["success_rate"] == 0.5
    assert row["intervals"]["success_rate"] == pytest.approx(share_interval(2, 4)), "the planned episodes count"
    assert row["intervals"]["path_mse_m2"] == [1.0, 3.0]
    assert row["intervals"]["accuracy"]["shadow"]["throttle"]["range"] is None, "one value alone"
    assert row["intervals"]["driving_score_2_1"] is None, "no spread"
    assert row["seeds_needed"] == {
        "success_rate": seeds_for_share(2, 4, 0.1),
        "path_mse_m2": seeds_for_mean(np.array([1.0, 3.0]), 0.1),
    }


def test_a_summary_does_not_depend_on_the_order_of_its_records() -> None:
    values = np.random.Generator(np.random.PCG64(5)).exponential(1.0, 12)
    records = [record(seed, "success", mse, 0.5 + 0.01 * mse) for seed, mse in enumerate(values)]
    jobs = Plan(("a",), ("clear",), ("pid",), "0:12").jobs()
    there, back = (json.dumps(summarize(jobs, found).as_json()) for found in (records, records[::-1]))
    assert there == back
