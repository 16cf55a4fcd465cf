"""Recomputes the records of a run folder from its steps, after a change of score definitions."""

from contextlib import closing
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from vpf_sim.envs.world import build_route
from vpf_sim.errors import InputError
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.analysis.rows import Summary
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, read_record, record_of
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import Outcome, StepTable
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint
from vpf_sim.evaluation.sweeps.manifest import MANIFEST, Manifest, read_manifest, stored_plan
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder, read_lines

SUMMARY = "summary.json"


@dataclass(frozen=True, slots=True)
class Rescored:
    """The new records and summary, with the changed keys by id."""

    records: list[Record]
    changed: dict[str, list[str]]
    planned: int
    command: str
    seeds: str
    summary: Summary


def rescore(path: Path) -> Rescored:
    """Rescore all records, store the changed ones, and the summary if no planned episode is missing.

    Unchanged records keep their bytes. A record changed by another version of the code gets this one's fingerprint, as
    with `--mixed`.
    """
    manifest, plan = read_manifest(path), stored_plan(path)
    jobs = {job.id: job for job in plan.jobs()}
    _check_scenarios(path, manifest, plan)
    inputs, now = RunInputs.of(path, manifest.made_in), fingerprint()
    mark = None if now == manifest.fingerprint else digest(now)
    with closing(RunFolder(path, manifest, resume=True)) as folder:
        lines = path / "episodes.jsonl"
        stored = [read_record(row, str(lines)) for row in read_lines(lines)]  # in their order in the file
        again = [_rescored(path, record, jobs, inputs) for record in stored]
        changed = {old.id: _differences(old, new) for old, new in zip(stored, again, strict=True) if old != new}
        kept = [record.marked(mark if record.id in changed else None) for record in again]
        if changed:
            folder.replace_records(kept)
        summary = summarize(jobs.values(), kept, manifest.privileged)
        if len(kept) == len(jobs):
            folder.write_json(SUMMARY, summary.as_json())
    return Rescored(kept, changed, len(jobs), manifest.command, plan.seeds, summary)


def score(job: Job, outcome: Outcome, inputs: RunInputs | None = None) -> Record:
    """The record of an episode from its outcome, on the scenario's route for its seed."""
    route = build_route((inputs or RunInputs()).scenario(job.scenario).draw(job.seed), job.seed)
    return record_of(job, outcome, route.waypoints(), route.length_m)


def _rescored(path: Path, record: Record, jobs: dict[str, Job], inputs: RunInputs) -> Record:
    """The record recomputed from its steps; unchanged without steps."""
    if record.id not in jobs:
        raise InputError(
            f"{path / 'episodes.jsonl'}: {record.id}: expected an episode of the plan in {MANIFEST}, got another"
        )
    if record.states_sha256 is None:
        return record
    table = _read_steps(path / "steps" / f"{record.id}.parquet", record.states_sha256)
    outcome = Outcome(
        record.status, table, record.collided_with, record.frames_sha256, invalid_frame=record.invalid_frame
    )
    return score(record.job, outcome, inputs).marked(record.fingerprint)


def _read_steps(path: Path, states_sha256: str) -> StepTable:
    table = steps.read(path)
    found = sha256(table.states()).hexdigest()
    if found != states_sha256:
        raise InputError(f"{path}: expected the states {states_sha256[:12]} of the record, got {found[:12]}")
    return table


def _check_scenarios(path: Path, manifest: Manifest, plan: Plan) -> None:
    """InputError where a scenario changed since the run, and with it its route."""
    for name, found in plan.scenario_hashes(RunInputs.of(path, manifest.made_in)).items():
        stored = manifest.scenarios.get(name)
        if stored != found:
            raise InputError(f"{path / MANIFEST}: scenario {name} changed since the run: was {stored}, is {found}")


def _differences(old: Record, new: Record) -> list[str]:
    """The keys of two records that differ."""
    before, after = old.as_json(), new.as_json()
    return sorted(key for key in before.keys() | after.keys() if before.get(key) != after.get(key))
