"""Read-only access to a run folder."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, datetime
from pathlib import Path
from typing import Any

from vpf_sim.errors import InputError, unknown_name
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.analysis.benchmark import with_paper
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.sweeps.json_lines import read_lines
from vpf_sim.evaluation.sweeps.run_folder import read_manifest, read_records
from vpf_sim.evaluation.sweeps.schema import Summary, Timing, checked
from vpf_sim.shell import command

Record = dict[str, Any]
SUMMARY = "summary.json"


@dataclass(frozen=True, slots=True)
class StoredRun:
    """The manifest, records and timing of a run."""

    path: Path
    manifest: dict[str, Any]
    records: dict[str, Record]  # by id, sorted
    timing: dict[str, dict[str, Any]]  # by id

    @property
    def begun(self) -> date | None:
        """The day on which the run began; None for one of an earlier version, which did not store it."""
        day = self.manifest.get("begun")
        return None if day is None else datetime.fromisoformat(day).date()

    @property
    def inputs(self) -> RunInputs:
        """What the run was driven with."""
        return RunInputs.of(self.path, self.manifest)

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
        if not record["steps"]:
            return f"never began ({record['status']})"
        return f"lost its steps: {self.path / 'steps' / episode_id}.parquet is gone"

    def reason(self, episode_id: str) -> str:
        """The last line of an episode's error file; empty without one."""
        path = self.path / "errors" / f"{episode_id}.txt"
        lines = path.read_text("utf-8", errors="replace").strip().splitlines() if path.exists() else []
        return lines[-1] if lines else ""

    def summary(self, jobs: Sequence[Job]) -> dict[str, Any]:
        """The stored summary, or a new one of the finished episodes if the run was interrupted."""
        path = self.path / SUMMARY
        if not path.exists():
            return with_paper(summarize(jobs, self.records.values(), self.manifest))
        try:
            summary = json.loads(path.read_bytes())
        except ValueError:
            summary = None
        if not isinstance(summary, dict):
            raise InputError(f"{path}: expected a JSON object, got something else; {self._remedy}")
        try:
            valid = checked(Summary, summary, str(path))
        except InputError as error:
            raise InputError(f"{error}; {self._remedy}") from None
        cells = {job[:3] for job in jobs}
        if {(row.scenario, row.weather, row.driver) for row in valid.rows} != cells or not _compares_cells(
            valid, cells
        ):
            raise InputError(f"{path}: expected the cells of the plan, got others; {self._remedy}")
        return summary

    @property
    def _remedy(self) -> str:
        return f"{command('score', self.path)} recreates it"


def _compares_cells(summary: Summary, cells: set[tuple[str, str, str]]) -> bool:
    """Whether all comparisons are between these cells."""
    for one in summary.comparisons:
        first = {"scenario": one.scenario, "weather": one.weather, "driver": one.driver}
        second = {**first, one.of: one.minus}
        if not {tuple(first.values()), tuple(second.values())} <= cells:
            return False
    return True


def open_run(path: Path) -> StoredRun:
    """The run in a folder."""
    if not path.is_dir():
        raise InputError(f"{path}: expected a run folder, got {'a file' if path.exists() else 'nothing of that name'}")
    manifest = read_manifest(path)
    records = {row["id"]: row for row in read_records(path)}
    timing = {
        row["id"]: row
        for row in read_lines(path / "timing.jsonl")
        if checked(Timing, row, f"{path / 'timing.jsonl'}: {row.get('id')!r}")
    }
    return StoredRun(path, manifest, records, timing)
