"""The benchmark's table on a terminal."""

from typing import Any

import pytest
from stored import record, records

from vpf_sim.cli.sweep_tables import print_benchmark
from vpf_sim.evaluation.analysis import benchmark
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.job import Job

SCREEN_LINES, SCREEN_COLUMNS = 24, 100
MORE_LINES = 2  # the command, and where the report is


def ended(job: Job) -> dict[str, Any]:
    """The widest values: full marks of all but two drivers, which never arrive."""
    accuracy = {"shadow": {"throttle": {"range": 1.0}, "steering": {"range": 1.0}}}
    status = "collision" if job.driver in ("vpf-literal", "pid") else "success"
    clearance_m = 0.5 if job.seed == 1003 else 0.7
    return record(job, status=status, path_mse_m2=12.3456, min_clearance_m=clearance_m, accuracy=accuracy)


def shown(capsys: pytest.CaptureFixture[str], seeds: str) -> list[str]:
    plan = benchmark.plan(seeds, [])
    rows = summarize(plan.jobs(), records(ended(job) for job in plan.jobs())).rows
    print_benchmark(rows, seeds)
    return capsys.readouterr().out.splitlines()


def test_it_fits_one_screen(capsys: pytest.CaptureFixture[str]) -> None:
    lines = shown(capsys, "20000:20100")
    assert len(lines) + MORE_LINES <= SCREEN_LINES
    assert max(map(len, lines)) <= SCREEN_COLUMNS


def test_each_cell_stands_beside_the_papers_values(capsys: pytest.CaptureFixture[str]) -> None:
    lines = shown(capsys, "1000:1004")
    cells = [" ".join(line.split()) for line in lines]
    assert cells[2] == "town04-clean clear vpf 4/4 12.346 / 0.42 100.0 / 82.3 100.0 / 72.1 0.50"
    assert cells[17] == "town04 rain pid [route] 0/4 - / 1.34 - / 70.8 - / 65.5 -"
    assert "Seeds 1000:1004: vpf reached the goal in 16 of 16 drives, at least 0.50 m from parked cars." in lines
