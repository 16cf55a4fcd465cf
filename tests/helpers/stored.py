"""Run folders without a run: what the gate, scores and reports read, written by hand."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, read_record, unscored
from vpf_sim.evaluation.sweeps.plan import Plan

GOOD = {
    "status": "success",
    "path_mse_m2": 0.4,
    "min_clearance_m": 0.5,
    "comfort": {"comfortable": True},
    "route_completion": 1.0,
    "max_lane_offset_m": 1.0,
    "steps": 10,
}


def record(job: Job, **changes: Any) -> dict[str, Any]:
    """The line of a good episode's record, with changes."""
    return {**unscored(job).as_json(), **GOOD, **changes}


def records(rows: Iterable[Mapping[str, Any]]) -> list[Record]:
    """The records of such lines."""
    return [read_record(dict(row), "a line") for row in rows]


def store(path: Path, plan: Plan, records: Iterable[Mapping[str, Any]], world: str = "as it is") -> Path:
    """A run folder of a plan; `world` stands for what its scenarios and weathers say."""
    path.mkdir(parents=True)
    hashes = {"scenarios": dict.fromkeys(plan.scenario, world), "weathers": dict.fromkeys(plan.weather, world)}
    requested = {key: getattr(plan, key) for key in ("scenario", "weather", "driver", "seeds")}
    manifest = {"schema": 1, "command": "sweep", "plan": requested, "fingerprint": {}, **hashes}
    (path / "manifest.json").write_text(json.dumps(manifest))
    (path / "episodes.jsonl").write_text("".join(json.dumps(row) + "\n" for row in records))
    return path
