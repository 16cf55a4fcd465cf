"""The benchmark: its plan, the paper's values, and the printed tables."""

import json
from pathlib import Path
from typing import Any

import pytest

from vpf_sim.cli.run_options import RunOptions, plan_of
from vpf_sim.cli.sweep_tables import exit_code, print_comparisons, print_rows
from vpf_sim.evaluation.analysis import benchmark
from vpf_sim.evaluation.analysis.rows import Cell, Comparison, Row, Summary, read_summary
from vpf_sim.evaluation.analysis.statistics import Difference, Interval


def row(scenario: str, driver: str, successes: int, **changes: Any) -> Row:
    accuracy = {
        protocol: {
            "throttle": {"range": 0.812, "span": 0.5, "tolerance": 0.25, "mae": 0.376},
            "steering": {"range": 0.975, "span": None, "tolerance": 1.0, "mae": 0.05},
            "clear_of_obstacles": {"throttle": {"range": 0.9}, "steering": {"range": 0.95}},
            "passing": {"throttle": None, "steering": None},
        }
        for protocol in ("shadow", "paired")
    }
    scores = {"path_mse_m2": 0.1234, "accuracy": accuracy}
    shadow = {"throttle": {"range": [0.801, 0.8234]}, "steering": {"range": None}}
    intervals = {"path_mse_m2": [0.1, 0.1501], "accuracy": {"shadow": shadow}, "driving_score_2_1": [0.85, 0.93]}
    nowhere = {"path_mse_m2": None, "accuracy": None, "driving_score_2_1": None}
    nothing = {"path_mse_m2": None, "accuracy": None}
    stored = {
        "scenario": scenario,
        "weather": "clear",
        "driver": driver,
        "privileged": "route" if driver == "pid" else "none",
        "episodes": 5,
        "successes": successes,
        "statuses": {"success": successes, "collision": 5 - successes},
        "least_clearance_m": 0.61,
        **(scores if successes else nothing),
        "driving_score_2_1": 0.9,
        "intervals": intervals if successes else nowhere,
        "unsuccessful": scores if successes < 5 else nothing,
        **changes,
    }
    return read_summary({"rows": [stored]}, "a summary").rows[0]


def test_the_benchmark_drives_the_papers_cells_with_its_drivers() -> None:
    plan = benchmark.plan("1000:1002", [])
    assert {job[:3] for job in plan.jobs()} == {
        (scenario, weather, driver)
        for scenario in ("town04-clean", "town04")
        for weather in ("clear", "rain")
        for driver in ("vpf", "vpf-paper", "vpf-literal", "pid")
    }
    assert {job.seed for job in plan.jobs()} == {1000, 1001}
    assert benchmark.plan(None, ["pid"]).driver == ("pid",)


def test_a_sweeps_table_rates_only_drives_that_arrived(capsys: pytest.CaptureFixture[str]) -> None:
    print_rows([row("town04", "pid", 0), row("town04", "vpf", 5)])
    out = capsys.readouterr().out
    assert "  pid [route]  " in out, "what a driver is told beyond its camera"
    lost = "town04 clear pid [route] 0/5 - 0.61 - - 0.90"
    assert lost.split() in [line.split() for line in out.splitlines()]
    ours = "town04 clear vpf 5/5 0.123 [0.100, 0.150] 0.61 81.2 [80.1, 82.3] 97.5 0.90 [0.85, 0.93]"
    assert ours.split() in [line.split() for line in out.splitlines()]


def test_differences_have_interval_p_and_seeds(capsys: pytest.CaptureFixture[str]) -> None:
    rate, mse = Difference(-0.2, Interval(-0.4, 0.012), 0.0625, 30), Difference(0.1234, None, 1.0, 2)
    cell = Cell("town04", "rain", "vpf")
    print_comparisons(
        [
            Comparison("weather", cell, "clear", {"success_rate": rate, "path_mse_m2": None}),
            Comparison("driver", cell, "pid", {"success_rate": rate, "path_mse_m2": mse}),
        ]
    )
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["town04", "rain", "-", "clear", "vpf", "-0.20", "[-0.40,", "0.01]", "0.062", "30", "-", "-", "0"] in lines
    assert [
        "town04",
        "rain",
        "vpf",
        "-",
        "pid",
        "-0.20",
        "[-0.40,",
        "0.01]",
        "0.062",
        "30",
        "0.123",
        "1.000",
        "2",
    ] in lines
    print_comparisons([])
    assert capsys.readouterr().out == "", "one weather and one driver"


@pytest.mark.parametrize(
    ("statuses", "code"),
    [({"success": 5}, 0), ({"collision": 5}, 0), ({"success": 4, "error": 1}, 1), ({"invalid_frame": 5}, 1)],
)
def test_a_collision_is_a_result_and_an_error_is_a_fault(statuses: dict[str, int], code: int) -> None:
    assert exit_code(Summary((row("town04", "pid", 5), row("town04", "vpf", 5, statuses=statuses)), ())) == code


@pytest.mark.parametrize(
    ("resume", "requested", "stored", "seeds"),
    [(True, False, True, "5:9"), (True, True, True, "0:1"), (False, False, True, "0:1"), (True, True, False, "0:1")],
)
def test_a_resumed_run_drives_its_stored_plan(
    resume: bool, requested: bool, stored: bool, seeds: str, tmp_path: Path
) -> None:
    grid = {"scenario": ["town04"], "weather": ["rain"], "driver": ["pid"]}
    if stored:
        manifest = {
            "plan": {**grid, "seeds": "5:9"},
            "fingerprint": {},
            "scenarios": {},
            "weathers": {},
            "command": "benchmark",
        }
        (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    plan = plan_of(RunOptions(out=tmp_path, resume=resume), requested, lambda: benchmark.plan("0:1", ["pid"]))
    assert plan.seeds == seeds
    assert plan_of(RunOptions(resume=resume), requested, lambda: plan) is plan, "there is no folder to go on with"
