"""A stored run as a verification reads it."""

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.rows import Summary, read_summary
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.sweeps.manifest import Manifest, read_manifest, stored_plan
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import read_records
from vpf_sim.files import read_object

SUMMARY, RECORDS = "summary.json", "episodes.jsonl"


@dataclass(frozen=True)
class Run:
    """The content of a run folder."""

    path: Path
    manifest: Manifest
    plan: Plan
    records: tuple[Record, ...]  # all lines, sorted by id
    summary: Summary | None  # None where the run was interrupted

    @classmethod
    def of(cls, path: Path) -> "Run":
        """The run in a folder; InputError for an unusable one."""
        if not path.is_dir():
            raise InputError(f"{path}: expected a run folder, got {'a file' if path.exists() else 'nothing'}")
        return cls(path, read_manifest(path), stored_plan(path), tuple(read_records(path)), _summary(path / SUMMARY))

    @cached_property
    def jobs(self) -> list[Job]:
        """The planned episodes in the plan's order, which says what is compared with what."""
        return self.plan.jobs()

    @property
    def records_sha256(self) -> str:
        """The hash of the records' file, which says what was verified."""
        return sha256((self.path / RECORDS).read_bytes()).hexdigest()

    @property
    def inputs(self) -> RunInputs:
        return RunInputs.of(self.path, self.manifest.made_in)

    def steps_file(self, episode: str) -> Path:
        return self.path / "steps" / f"{episode}.parquet"


def _summary(file: Path) -> Summary | None:
    return read_summary(read_object(file), str(file)) if file.exists() else None
