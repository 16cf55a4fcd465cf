"""Invalid files of run folders: one line with file, position and fault."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import stored
from stored import record, store

from vpf_sim import cli
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.reporting.run_data import open_run

PLAN = Plan(("straight",), ("clear", "rain"), ("pid",), "0:2")
Break = Callable[[Any], Any]


@pytest.fixture
def run(tmp_path: Path) -> Path:
    records = [record(job) for job in PLAN.jobs()]
    path = store(tmp_path / "run", PLAN, records)
    (path / "summary.json").write_text(json.dumps(summarize(PLAN.jobs(), stored.records(records)).as_json()))
    (path / "timing.jsonl").write_text(json.dumps({"id": records[0]["id"], "wall_s": 2.0, "steps_per_s": 5.0}) + "\n")
    return path


def put(value: Any, *place: str | int) -> Break:
    """Write a value at a place, whatever stands there."""

    def change(table: Any) -> Any:
        inner = table
        for key in place[:-1]:
            inner = inner[key]
        inner[place[-1]] = value
        return table

    return change


def spoil(path: Path, change: Break) -> None:
    """Change the JSON of a file, or of its first line."""
    first, _, rest = path.read_text().partition("\n")
    path.write_text(json.dumps(change(json.loads(first))) + "\n" + rest)


def test_written_files_match_the_schema(run: Path) -> None:
    found = open_run(run)
    assert len(found.records) == 4
    assert len(found.summary().rows) == 2


@pytest.mark.parametrize(
    ("file", "change", "sentence"),
    [
        ("episodes.jsonl", put(True, "comfort"), 'pid.0": comfort: expected a table of numbers, got True'),
        ("episodes.jsonl", put([], "perception"), 'straight.clear.pid.0": perception: expected a valid number, got []'),
        ("episodes.jsonl", put({"passing": "far"}, "path_mse_parts_m2"), "path_mse_parts_m2.passing: expected a valid"),
        ("episodes.jsonl", put("rain", "weather"), "expected the id of its scenario, weather, driver and seed, which"),
        ("manifest.json", put(3, "command"), "command: expected a valid string, got 3"),
        ("manifest.json", put({"straight": 3}, "scenarios"), "scenarios.straight: expected a valid string, got 3"),
        ("timing.jsonl", put({}, "wall_s"), "'straight.clear.pid.0': wall_s: expected a valid number, got {}"),
        ("timing.jsonl", put(7, "stages_ms"), "'straight.clear.pid.0': stages_ms: expected a valid dictionary, got 7"),
        ("summary.json", lambda _: [1], "expected a JSON object, got something else; vpf-sim score"),
        ("summary.json", put("x", "rows", 0, "driver"), "expected the cells of the plan, got others; vpf-sim score"),
        ("summary.json", put("x", "comparisons", 0, "minus"), "expected the cells of the plan, got others; vpf-sim"),
        (
            "summary.json",
            put({}, "rows", 0, "statuses", "success"),
            "rows.0: statuses.success: expected a valid integer",
        ),
        (
            "summary.json",
            put([1], "rows", 0, "intervals", "path_mse_m2"),
            "rows.0.intervals.path_mse_m2: expected two numbers",
        ),
    ],
)
def test_an_invalid_file_is_one_line(
    run: Path, file: str, change: Break, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil(run / file, change)
    assert cli.run(["report", str(run), "--clips", "0"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    (line,) = [line for line in said.err.splitlines() if line.startswith("vpf-sim: ")]
    assert line.startswith(f"vpf-sim: {run / file}: ")
    assert sentence in line
    assert not (run / "report.html").exists()
