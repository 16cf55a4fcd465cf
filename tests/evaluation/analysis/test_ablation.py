"""The ablation's table against numbers counted by hand, and the command on the shortest drive."""

import json
from pathlib import Path
from typing import Any

import pytest
from short_scenario import SHORT

from vpf_sim import cli
from vpf_sim.evaluation.analysis import ablation
from vpf_sim.evaluation.job import Job

STEPS = ("vpf-paper", "vpf@flow", "vpf")


def record(driver: str, seed: int, good: bool, mse: float, turns: float) -> dict[str, Any]:
    job = Job("town04", "clear", driver, seed)
    return {
        "id": job.id,
        **job._asdict(),
        "status": "success" if good else "collision",
        "route_completion": 1.0 if good else 0.5,
        "path_mse_m2": mse,
        "min_clearance_m": 0.5 if good else 0.0,
        "comfort": {"comfortable": good and turns < 5.0},
        "chattering": {"steering": {"direction_changes_per_s": turns}},
    }


def test_scores_and_differences_are_over_the_same_seeds() -> None:
    jobs = [Job("town04", "clear", driver, seed) for driver in STEPS for seed in range(4)]
    records = [record("vpf-paper", seed, seed < 2, 1.0 + seed, 20.0) for seed in range(4)]
    records += [record("vpf@flow", seed, seed < 3, 0.5 + seed, 10.0) for seed in range(4)]
    records += [record("vpf", seed, True, 0.25, 1.0 + seed) for seed in range(3)]  # the fourth is missing
    timing = [{"id": one["id"], "stages_ms": {"driver": 5.0 if "flow" in one["id"] else 8.0}} for one in records]
    paper, flow, robust = ablation.table(jobs, records, timing)["rows"]
    assert [row["driver"] for row in (paper, flow, robust)] == list(STEPS)
    assert paper["difference"] is None
    assert (paper["successes"], paper["success_rate"], paper["path_mse_m2"]) == (2, 0.5, 1.5)
    assert (paper["comfortable_rate"], paper["steering_changes_per_s"], paper["driver_ms"]) == (0.0, 20.0, 8.0)
    assert (robust["successes"], robust["success_rate"], robust["comfortable_rate"]) == (3, 0.75, 0.75)
    change = flow["difference"]
    assert (change["success_rate"]["difference"], change["success_rate"]["pairs"]) == (0.25, 4)
    assert (change["path_mse_m2"]["difference"], change["path_mse_m2"]["pairs"]) == (-0.5, 2)
    assert change["steering_changes_per_s"]["difference"] == -10.0
    assert (change["driver_ms"]["difference"], change["driver_ms"]["pairs"]) == (-3.0, 4)
    change = robust["difference"]
    assert change["success_rate"]["difference"] == 0.0, "a missing episode is no success"
    assert (change["path_mse_m2"]["difference"], change["path_mse_m2"]["pairs"]) == (-1.25, 3)
    assert change["steering_changes_per_s"]["difference"] == -8.0
    low, high = change["path_mse_m2"]["interval"]
    assert low < -1.25 < high


def test_a_step_without_any_record_has_no_scores() -> None:
    jobs = [Job("town04", "clear", driver, 0) for driver in STEPS[:2]]
    paper, flow = ablation.table(jobs, [], [])["rows"]
    assert (paper["successes"], paper["path_mse_m2"], paper["driver_ms"]) == (0, None, None)
    assert flow["difference"]["path_mse_m2"] is None
    assert flow["difference"]["success_rate"]["difference"] == 0.0


def test_the_grid_goes_from_the_full_frame_to_ours() -> None:
    drivers = ablation.plan(None, [], []).driver
    assert (drivers[0], drivers[-1]) == ("vpf@full-frame", "vpf")
    assert len(set(drivers)) == len(drivers) >= 8
    assert all(name.startswith("vpf@") for name in drivers[1:-1])
    asked = ablation.plan("3:5", ["random"], ["rain"])
    assert (asked.scenario, asked.weather, asked.seeds) == (("random",), ("rain",), "3:5")


@pytest.fixture
def two_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    steps = ablation.ablation_steps()
    shown = {key: steps[key] for key in ("vpf@lane_planner", "vpf@memory")}
    monkeypatch.setattr(ablation, "ablation_steps", lambda _="robust": shown)


@pytest.mark.usefixtures("two_steps")
def test_the_command_stores_a_run_folder_with_the_ablation_table(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    short, out = tmp_path / "short.toml", tmp_path / "out"
    short.write_text(SHORT.replace("11.0", "6.0"))
    asked = ["ablate", "--scenario", str(short), "--seeds", "0:1", "--workers", "1", "--out", str(out)]
    assert cli.run([*asked, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows"] == json.loads((out / "ablation.json").read_text())["rows"]
    assert [row["driver"] for row in told["rows"]] == ["vpf@lane_planner", "vpf@memory"]
    assert all(row["successes"] == 1 and row["driver_ms"] > 0.0 for row in told["rows"])
    steps = {path.stem for path in (out / "steps").iterdir()}
    assert {stem.split(".")[2] for stem in steps} == {"vpf@lane_planner", "vpf@memory"}
    assert cli.run(["score", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["changed"] == []
    assert cli.run(["ablate", "--out", str(out), "--resume"]) == 0
    said = capsys.readouterr().out
    assert "vpf@memory: lateral cost: leaving the last minimum" in said
    assert "Differences to the previous step" in said


def test_wrong_use_is_one_clear_line(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, sentence in (
        (["--seeds", "5:2"], "--seeds: expected A:B with A below B"),
        (["--scenario", "twon04"], "unknown scenario 'twon04': did you mean 'town04'?"),
        (["--resume"], "--resume: expected the folder of the run in --out, got none"),
    ):
        assert cli.run(["ablate", *arguments]) == 2
        assert capsys.readouterr().err.startswith(f"vpf-sim: {sentence}")
