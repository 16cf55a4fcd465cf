"""Perception rules on hand-written metrics."""

import json
from pathlib import Path
from typing import Any

import pytest
from stored import record, store

from vpf_sim.errors import InputError
from vpf_sim.evaluation.gate import gate
from vpf_sim.evaluation.gate.checks import Check
from vpf_sim.evaluation.gate.perception_rules import check
from vpf_sim.evaluation.gate.rules import PerceptionBounds, read_rules
from vpf_sim.evaluation.gate.run_cells import Cell, read_run
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.perception import store as tables
from vpf_sim.evaluation.perception.scores import ERRORS
from vpf_sim.evaluation.sweeps.plan import Plan

PLAN = Plan(("town04",), ("clear",), ("pid",), "0:3")
CELL = Cell("town04", "clear", "vpf")
GOOD: dict[str, Any] = {"recall": 1.0, "precision": 1.0, "false_positives_per_minute": 0.0}
GOOD |= {key: {"median": 0.1, "p95": 0.4} for key in ERRORS}
BAD = GOOD | {"recall": 0.5, "precision": 0.7, "edge_error_m": {"median": 0.3, "p95": 0.4}}


def perceived(path: Path, of_drives: dict[int, dict[str, Any]], row: dict[str, Any]) -> Path:
    """A run of the PID with what `vpf` perceived on some of its three seeds."""
    states = {job: record(job, states_sha256=f"states {job.seed}") for job in PLAN.jobs()}
    store(path, PLAN, states.values())
    names = {"scenario": "town04", "weather": "clear", "driver": "vpf"}
    records = [
        {"drive": Job("town04", "clear", "pid", seed).id, "seed": seed, "bodies": [], **names, **GOOD, **figures}
        for seed, figures in of_drives.items()
    ]
    stored = [{"states_sha256": f"states {one['seed']}", **one} for one in records]
    tables.write(path / tables.NAME, {"records": stored, "rows": [{**names, **GOOD, **row}]})
    return path


def held(path: Path, bound: str) -> Check:
    """The one check of a bound."""
    file = path.parent / "rules.toml"
    file.write_text(f"[[rules]]\nperception.{bound}\n")
    (found,) = gate.check(read_run(path), read_rules(file), file)
    assert found.cell == CELL, "its driver is the one that perceived"
    return found


@pytest.mark.parametrize(
    ("bound", "outcome", "actual", "seeds"),
    [
        ("recall_at_least = 0.8", "passed", "0.8 over 3 drives", ()),
        ("recall_at_least = 0.81", "failed", "0.8 over 3 drives", (1,)),
        ("precision_at_least = 0.95", "failed", "0.9 over 3 drives", (1,)),
        ("false_positives_per_minute_at_most = 0", "passed", "0 over 3 drives", ()),
        ("edge_error_m_at_most = 0.15", "failed", "0.2 over 3 drives", (1,)),
        ("edge_error_m_p95_at_most = 0.4", "passed", "0.4 over 3 drives", ()),
        ("foe_error_px_p95_at_most = 0.3", "failed", "0.4 over 3 drives", (0, 1, 2)),
        ("speed_error_mps_at_most = 0.1", "skipped", "none over 3 drives", ()),
        ("lane_error_m_at_most = 0.1", "failed", "none over 3 drives", ()),
    ],
)
def test_bounds(bound: str, outcome: str, actual: str, seeds: tuple[int, ...], tmp_path: Path) -> None:
    row = {"recall": 0.8, "precision": 0.9, "edge_error_m": {"median": 0.2, "p95": 0.4}}
    row |= {"speed_error_mps": None, "lane_error_m": None}
    found = held(perceived(tmp_path / "run", {0: {}, 1: BAD, 2: {}}, row), bound)
    assert (found.expected, found.outcome, found.actual, found.seeds) == (
        f"perception.{bound.replace(' = ', ' ')}",
        outcome,
        actual,
        seeds,
    )


def test_the_rerun_command_has_the_worst_drives(tmp_path: Path) -> None:
    found = held(perceived(tmp_path / "run", {0: {}, 1: BAD, 2: {}}, {"recall": 0.8}), "recall_at_least = 0.9")
    assert found.rerun == f"vpf-sim perception {tmp_path / 'run'} --driver vpf --id town04.clear.pid.1"


@pytest.mark.parametrize(
    ("of_drives", "actual"),
    [
        ({0: {}, 2: {}}, "1 over 2 drives, 1 not perceived"),
        ({0: {}, 1: {"states_sha256": "before it was driven anew"}, 2: {}}, "1 over 3 drives, 1 not perceived"),
    ],
)
def test_a_drive_without_perception_fails_the_rule(
    of_drives: dict[int, dict[str, Any]], actual: str, tmp_path: Path
) -> None:
    found = held(perceived(tmp_path / "run", of_drives, {}), "recall_at_least = 0.9")
    assert (found.outcome, found.actual) == ("failed", actual)
    assert found.rerun == f"vpf-sim perception {tmp_path / 'run'} --driver vpf", "all of them"


def test_without_met_objects_recall_and_distance_are_skipped(tmp_path: Path) -> None:
    nothing = {"recall": None, "precision": None, "distance_error_m": None}
    run = perceived(tmp_path / "run", {0: nothing, 1: nothing, 2: nothing}, nothing)
    bounds = ("recall_at_least = 1", "precision_at_least = 1", "distance_error_m_at_most = 0")
    assert [held(run, bound).outcome for bound in bounds] == ["skipped"] * 3


def test_every_bound_has_a_metric(tmp_path: Path) -> None:
    run = read_run(perceived(tmp_path / "run", {0: {}, 1: {}, 2: {}}, {}))
    bounds = PerceptionBounds(
        **{key: 1.0 if key.endswith("least") else 2.0 for key in PerceptionBounds.__dataclass_fields__}
    )
    (tmp_path / "rules.toml").write_text("[[rules]]\nperception.recall_at_least = 1\n")
    (rule,) = read_rules(tmp_path / "rules.toml")
    found = check(run, rule, bounds, "rules[0].perception")
    assert len(found) == 3 + 2 * len(ERRORS)
    assert {one.outcome for one in found} == {"passed"}


def test_other_bounds_of_the_rule_apply_to_the_driver_of_the_run(tmp_path: Path) -> None:
    path = perceived(tmp_path / "run", {0: {}, 1: {}, 2: {}}, {})
    file = tmp_path / "rules.toml"
    file.write_text("[[rules]]\ncollisions_at_most = 0\nperception.recall_at_least = 1\n")
    found = gate.check(read_run(path), read_rules(file), file)
    assert [(one.cell.driver, one.outcome) for one in found] == [("vpf", "passed"), ("pid", "passed")]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda _: [], "expected a JSON object, got something else"),
        (lambda stored: {**stored, "rows": 3}, "rows: expected a valid list, got 3"),
        (lambda stored: {key: stored[key] for key in ("rows", "schema")}, "key 'records' is missing"),
    ],
)
def test_an_invalid_table_is_reported_by_file_and_key(change: Any, sentence: str, tmp_path: Path) -> None:
    file = perceived(tmp_path / "run", {0: {}}, {}) / tables.NAME
    file.write_text(json.dumps(change(json.loads(file.read_text()))))
    with pytest.raises(InputError) as stored:
        tables.read(tmp_path / "run")
    assert str(stored.value) == f"{file}: {sentence}"
