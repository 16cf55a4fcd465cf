"""Recomputes the records of a run folder from its steps, after a change of score definitions."""

from contextlib import closing
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from vpf_sim.envs.world import build_route
from vpf_sim.errors import InputError
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.analysis.benchmark import with_paper
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics import records
from vpf_sim.evaluation.outcome import Outcome
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint
from vpf_sim.evaluation.sweeps.json_lines import read_lines
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import MANIFEST, RunFolder, read_manifest, stored_plan

Record = dict[str, Any]
SUMMARY = "summary.json"
KEPT = ("status", "collided_with", "frames_sha256", "invalid_frame")  # values that the steps do not contain


@dataclass(frozen=True, slots=True)
class Rescored:
    """The new records and summary, with the changed keys by id."""

    records: list[Record]
    changed: dict[str, list[str]]
    planned: int
    command: str
    seeds: str
    summary: dict[str, Any]


def rescore(path: Path) -> Rescored:
    """Rescore all records, store the changed ones, and the summary if no planned episode is missing.

    Unchanged records keep their bytes. A record changed by another version of the code gets this one's fingerprint, as
    with `--mixed`.
    """
    manifest, plan = read_manifest(path), stored_plan(path)
    jobs = {job.id: job for job in plan.jobs()}
    _check_scenarios(path, manifest, plan)
    inputs, now = RunInputs.of(path, manifest), fingerprint()
    mark = {} if now == manifest["fingerprint"] else {"fingerprint": digest(now)}
    with closing(RunFolder(path, manifest, resume=True)) as folder:
        stored = read_lines(path / "episodes.jsonl")
        again = [_rescored(path, record, jobs, inputs) for record in stored]
        changed = {old["id"]: _differences(old, new) for old, new in zip(stored, again, strict=True) if old != new}
        kept = [{**new, **mark} if new["id"] in changed else new for new in again]
        if changed:
            folder.replace_records(kept)
        summary = with_paper(summarize(jobs.values(), kept, manifest))
        if len(kept) == len(jobs):
            folder.write_json(SUMMARY, summary)
    return Rescored(kept, changed, len(jobs), str(manifest.get("command")), plan.seeds, summary)


def score(job: Job, outcome: Outcome, inputs: RunInputs | None = None) -> Record:
    """The record of an episode from its outcome, on the scenario's route for its seed."""
    route = build_route((inputs or RunInputs()).scenario(job.scenario).draw(job.seed), job.seed)
    return records.score(job, outcome, route.waypoints(), route.length_m)


def _rescored(path: Path, record: Record, jobs: dict[str, Job], inputs: RunInputs) -> Record:
    """The record recomputed from its steps; unchanged without steps."""
    where = f"{path / 'episodes.jsonl'}: {record.get('id')}"
    if record.get("id") not in jobs:
        raise InputError(f"{where}: expected an episode of the plan in {MANIFEST}, got another")
    for key in (*KEPT, "steps", "states_sha256"):
        if key not in record:
            raise InputError(f"{where}: key '{key}' is missing")
    if record["states_sha256"] is None:
        return record
    table = _read_steps(path / "steps" / f"{record['id']}.parquet", record["states_sha256"])
    new = score(jobs[record["id"]], Outcome(steps=table, **{key: record[key] for key in KEPT}), inputs)
    return {**new, **{key: record[key] for key in ("fingerprint",) if key in record}}


def _read_steps(path: Path, states_sha256: str) -> StepTable:
    table = steps.read(path)
    found = sha256(table.states()).hexdigest()
    if found != states_sha256:
        raise InputError(f"{path}: expected the states {states_sha256[:12]} of the record, got {found[:12]}")
    return table


def _check_scenarios(path: Path, manifest: dict[str, Any], plan: Plan) -> None:
    """InputError where a scenario changed since the run, and with it its route."""
    for name, found in plan.scenario_hashes(RunInputs.of(path, manifest)).items():
        stored = (manifest.get("scenarios") or {}).get(name)
        if stored != found:
            raise InputError(f"{path / MANIFEST}: scenario {name} changed since the run: was {stored}, is {found}")


def _differences(old: Record, new: Record) -> list[str]:
    return sorted(key for key in old.keys() | new.keys() if old.get(key) != new.get(key))
