"""The data of a report: a run with its plan, records and summary, read once."""

from dataclasses import dataclass

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.rows import Row, Summary
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.reporting.cells import Order
from vpf_sim.reporting.stored_run import StoredRun


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
