"""Evaluates drivers on stored drives, as one table and as one per run folder."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from vpf_sim.evaluation.perception import scores, store
from vpf_sim.evaluation.perception.replay import Evaluated, StoredDrive, replay
from vpf_sim.evaluation.perception.scorer import DriveEvaluation

Notify = Callable[[StoredDrive], None]


def measure(drives: Iterable[StoredDrive], names: Sequence[str], workers: int, notify: Notify) -> list[Evaluated]:
    """Evaluate the named drivers on each drive; `notify` is called with each finished drive."""
    found = []
    for drive, evaluations in replay(drives, names, workers):
        found.append((drive, evaluations))
        notify(drive)
    return found


def table(found: Iterable[Evaluated]) -> dict[str, Any]:
    """The metrics of all drives: `records`, `rows`, `totals` (see `scores.table`)."""
    return scores.table(_flat(found))


def store_by_run(found: Sequence[Evaluated]) -> None:
    """Store the metrics of each run's drives in its folder, for rules of the gate."""
    for folder in {drive.folder for drive, _ in found}:
        own = [(drive, evaluations) for drive, evaluations in found if drive.folder == folder]
        store.write(folder / store.NAME, table(own))


def _flat(found: Iterable[Evaluated]) -> list[DriveEvaluation]:
    return [evaluation for _, evaluations in found for evaluation in evaluations]
