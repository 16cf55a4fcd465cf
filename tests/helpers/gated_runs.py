"""Runs whose scores are known, held to rules."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from stored import record, records, store

from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.gate import gate
from vpf_sim.evaluation.gate.checks import Check
from vpf_sim.evaluation.gate.rules import read_rules
from vpf_sim.evaluation.gate.run_cells import read_run
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import Plan

PLAN = Plan(("town04", "straight"), ("clear",), ("vpf",), "0:10")
Change = Callable[[Job], dict[str, Any] | None]


def run(path: Path, change: Change, plan: Plan = PLAN, world: str = "as it is") -> Path:
    """A run folder: a good record for each planned episode, with changes, or none where the change is None."""
    changes = {job: change(job) for job in plan.jobs()}
    rows = [record(job, **found) for job, found in changes.items() if found is not None]
    store(path, plan, rows, world)
    (path / "summary.json").write_text(json.dumps(summarize(plan.jobs(), records(rows)).as_json()))
    return path


def checks(tmp_path: Path, rules: str, change: Change = lambda _: {}) -> list[Check]:
    file = tmp_path / "rules.toml"
    file.write_text(rules)
    return gate.check(read_run(run(tmp_path / "run", change)), read_rules(file), file)


def only(tmp_path: Path, bound: str, change: Change) -> Check:
    """The one check of a bound on town04."""
    (found,) = checks(tmp_path, f'[[rules]]\nscenario = "town04"\n{bound}', change)
    return found


def lost(job: Job) -> dict[str, Any] | None:
    """Of ten seeds 3 has no record, 5 ended in a collision, 8 in an error."""
    ends = {5: {"status": "collision", "collisions": 1}, 8: {"status": "error", "path_mse_m2": None, "comfort": None}}
    return None if job.seed == 3 else ends.get(job.seed, {})


def spread(job: Job) -> dict[str, Any]:
    """Of ten seeds 3, 5 and 8 left the road; path MSE is seed / 10."""
    return {"path_mse_m2": job.seed / 10.0, "status": "off_road" if job.seed in (3, 5, 8) else "success"}
