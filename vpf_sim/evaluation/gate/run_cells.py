"""The cells (scenario, weather, driver) of a stored run, with the checked values of each planned episode."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.rows import Cell
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import COLLISIONS, COMFORTABLE, SUCCESS, with_rules
from vpf_sim.evaluation.sweeps.manifest import Manifest, read_manifest, stored_plan
from vpf_sim.evaluation.sweeps.run_folder import read_records

METRICS = with_rules()
FAULTS = ("error", "invalid_frame")  # statuses of episodes that did not finish


Episodes = Mapping[int, Record | None]  # by seed, all planned ones; None without a record


@dataclass(frozen=True, slots=True)
class Run:
    """A run's episodes by cell, and the hashes of its scenarios and weathers."""

    path: Path
    cells: dict[Cell, Episodes]
    manifest: Manifest


def read_run(path: Path) -> Run:
    """The validated run in a folder."""
    if not path.is_dir():
        raise InputError(f"{path}: expected a run folder, got {'a file' if path.exists() else 'nothing of that name'}")
    found = {record.id: record for record in read_records(path)}
    cells: dict[Cell, dict[int, Record | None]] = {}
    for job in stored_plan(path).jobs():
        cells.setdefault(Cell(*job[:3]), {})[job.seed] = found.get(job.id)
    return Run(path, dict(sorted(cells.items())), read_manifest(path))


def value_of(score: str, record: Record | None) -> float | None:
    """An episode's value in the mean of a score.

    A missing or unfinished episode counts as unsuccessful, uncomfortable, and a collision. All other scores are None
    for unsuccessful episodes, and where they were not measured, such as a clearance without obstacles.
    """
    metric, succeeded = METRICS[score], record is not None and record.succeeded
    if metric is COLLISIONS:
        return 1.0 if record is None or record.status in FAULTS else record[COLLISIONS]
    if metric is SUCCESS:
        return float(succeeded)
    if metric is COMFORTABLE:
        return float(record is not None and succeeded and bool(record[COMFORTABLE]))
    return record[metric] if record is not None and succeeded else None


def values_of(score: str, episodes: Episodes) -> dict[int, float]:
    """Values by seed of the episodes that count in a score."""
    values = {seed: value_of(score, episode) for seed, episode in episodes.items()}
    return {seed: value for seed, value in values.items() if value is not None}


def worst_first(losses: Mapping[int, float]) -> list[int]:
    """Seeds sorted by loss, largest first."""
    return sorted(losses, key=lambda seed: (-losses[seed], seed))
