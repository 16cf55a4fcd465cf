"""The instrument: what drivers perceive on stored drives, as one table, and as one for each run folder."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from vpf_sim.evaluation.perception import scores, store
from vpf_sim.evaluation.perception.replay import Evaluated, StoredDrive, replay
from vpf_sim.evaluation.perception.scorer import DriveEvaluation

Tell = Callable[[StoredDrive], None]


def measure(drives: Iterable[StoredDrive], names: Sequence[str], workers: int, tell: Tell) -> list[Evaluated]:
    """Let the drivers of these names perceive each drive; `tell` hears of each drive that is ready."""
    found = []
    for drive, judgements in replay(drives, names, workers):
        found.append((drive, judgements))
        tell(drive)
    return found


def table(found: Iterable[Evaluated]) -> dict[str, Any]:
    """The figures of all drives: `records`, `rows`, `totals` (see `scores.table`)."""
    return scores.table(_flat(found))


def keep(found: Sequence[Evaluated]) -> None:
    """Store the figures of each run's drives in its folder, where rules find them."""
    for folder in {drive.folder for drive, _ in found}:
        own = [(drive, judgements) for drive, judgements in found if drive.folder == folder]
        store.write(folder / store.NAME, table(own))


def _flat(found: Iterable[Evaluated]) -> list[DriveEvaluation]:
    return [judgement for _, judgements in found for judgement in judgements]
