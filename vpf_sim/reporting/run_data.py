"""The data of a report: a run with its plan, records and summary, read once."""

from dataclasses import dataclass
from datetime import date, datetime
from pathlib import Path

from vpf_sim.errors import InputError, unknown_name
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.analysis.rows import Cell, Row, Summary, read_summary
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, Timing
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.sweeps.manifest import MANIFEST, Manifest, read_manifest
from vpf_sim.evaluation.sweeps.plan import Plan, make_plan
from vpf_sim.evaluation.sweeps.run_folder import read_records, read_timing
from vpf_sim.files import read_object
from vpf_sim.reporting.main_table import Order
from vpf_sim.system import command

SUMMARY = "summary.json"


@dataclass(frozen=True, slots=True)
class StoredRun:
    """The manifest, records and timing of a run."""

    path: Path
    manifest: Manifest
    records: dict[str, Record]  # by id, sorted
    timing: dict[str, Timing]  # by id

    @property
    def begun(self) -> date | None:
        """The day on which the run began; None for one of an earlier version, which did not store it."""
        day = self.manifest.begun
        return None if day is None else datetime.fromisoformat(day).date()

    @property
    def inputs(self) -> RunInputs:
        """What the run was driven with."""
        return RunInputs.of(self.path, self.manifest.made_in)

    def plan(self) -> Plan:
        return make_plan(self.manifest.plan, str(self.path / MANIFEST))

    def record(self, episode_id: str) -> Record:
        """The record of an episode; InputError with the nearest id if it is unknown."""
        if not self.records:
            raise InputError(f"{self.path}: expected at least one finished episode, got none")
        if episode_id not in self.records:
            raise unknown_name(f"episode of {self.path}", episode_id, self.records)
        return self.records[episode_id]

    def steps(self, episode_id: str) -> StepTable | None:
        """The steps of an episode; None where there are none, for the reason of `why_no_steps`."""
        path = self.path / "steps" / f"{episode_id}.parquet"
        if not path.exists():
            return None
        table = steps.read(path)
        return table if len(table) else None

    def why_no_steps(self, episode_id: str) -> str:
        """Why an episode has no steps: it never began, or its file is gone."""
        record = self.record(episode_id)
        if not record.steps:
            return f"never began ({record.status})"
        return f"lost its steps: {self.path / 'steps' / episode_id}.parquet is gone"

    def reason(self, episode_id: str) -> str:
        """The last line of an episode's error file; empty without one."""
        path = self.path / "errors" / f"{episode_id}.txt"
        lines = path.read_text("utf-8", errors="replace").strip().splitlines() if path.exists() else []
        return lines[-1] if lines else ""

    def summary(self) -> Summary:
        """The stored summary, or a new one of the finished episodes if the run was interrupted."""
        path, jobs = self.path / SUMMARY, self.plan().jobs()
        if not path.exists():
            return summarize(jobs, self.records.values(), self.manifest.privileged)
        remedy = f"{command('score', self.path)} recreates it"
        try:
            summary = read_summary(read_object(path), str(path))
        except InputError as error:
            raise InputError(f"{error}; {remedy}") from None
        if not summary.has_cells({Cell(*job[:3]) for job in jobs}):
            raise InputError(f"{path}: expected the cells of the plan, got others; {remedy}")
        return summary


def open_run(path: Path) -> StoredRun:
    """The run in a folder."""
    if not path.is_dir():
        raise InputError(f"{path}: expected a run folder, got {'a file' if path.exists() else 'nothing of that name'}")
    manifest = read_manifest(path)
    return StoredRun(path, manifest, {record.id: record for record in read_records(path)}, read_timing(path))


@dataclass(frozen=True, slots=True)
class RunData:
    """A complete or interrupted run."""

    run: StoredRun
    plan: Plan
    jobs: list[Job]
    order: Order
    records: dict[str, Record]  # of the plan, by id
    summary: Summary

    @classmethod
    def of(cls, run: StoredRun) -> "RunData":
        """The data of a stored run."""
        plan = run.plan()
        jobs = plan.jobs()
        records = {job.id: run.records[job.id] for job in jobs if job.id in run.records}
        return cls(run, plan, jobs, Order(plan.scenario, plan.weather, plan.driver), records, run.summary())

    @property
    def command(self) -> str:
        return self.run.manifest.command

    @property
    def rows(self) -> list[Row]:
        """The summary's rows in the order of the plan."""
        return self.order.sorted(self.summary.rows)

    def at(self, scenario: str, weather: str) -> list[Record]:
        """The records of a scenario in a weather, driver by driver."""
        found = [record for record in self.records.values() if record.cell[:2] == (scenario, weather)]
        return sorted(found, key=lambda record: (*self.order.place(record), record.seed))

    def failures(self) -> list[Record]:
        """The unsuccessful records."""
        failed = [record for record in self.records.values() if not record.succeeded]
        return sorted(failed, key=lambda record: (*self.order.place(record), record.seed))

    def changed(self) -> set[str]:
        """Scenarios, weathers and drivers that changed since the run."""
        try:
            now = self.plan.hashes(self.run.inputs)
        except InputError:  # one is missing here; the code that needs it reports it
            return set()
        before = {kind: self.run.manifest.hashes(kind) for kind in now}
        return {name for kind in now for name, found in now[kind].items() if before[kind].get(name, found) != found}
