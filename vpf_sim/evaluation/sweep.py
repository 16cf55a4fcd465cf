"""A sweep: the planned episodes over worker processes into a run folder, from the start or from where it was left."""

import os
import platform
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from traceback import format_exc
from typing import Any

from vpf_sim.evaluation import pool, records, steps
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.run_folder import RunFolder

Stored = tuple[dict[str, Any], dict[str, Any]]  # record, timing


def run(folder: RunFolder, jobs: list[Job], workers: int, tell: Callable[[dict[str, Any]], None]) -> None:
    """Drive what the folder does not have yet; `tell` hears of each record as it is stored."""
    missing = [job for job in jobs if job.id not in folder.done]
    results: Iterator[pool.Done[Job, Stored]] = pool.run(
        partial(drive_and_store, folder.path, folder.mark), missing, workers
    )
    for done in results:
        record, timing = done.result or _given_up(done.task, folder.mark)
        timing |= {"worker": done.worker, "retries": done.attempts - 1}
        folder.add(record, timing)
        tell(record)


def drive_and_store(folder: Path, mark: str | None, job: Job) -> Stored:
    """Drive one episode, store its steps, and give its record and timing; whatever goes wrong in it is an `error`."""
    from vpf_sim.evaluation import episode

    try:
        result = episode.run(*job)
    except Exception:
        return _given_up(job, mark, format_exc())
    steps.write(result.steps, folder / "steps" / f"{job.id}.parquet")
    return _marked(result.record, mark), {**result.timing, "host": platform.node(), "process": os.getpid()}


def default_workers() -> int:
    """One a core that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _given_up(job: Job, mark: str | None, reason: str = "the worker process died at every attempt") -> Stored:
    return _marked(records.failed(job), mark), {"id": job.id, "traceback": reason, "host": platform.node()}


def _marked(record: dict[str, Any], mark: str | None) -> dict[str, Any]:
    """A record made on another fingerprint than the run's says so."""
    return record if mark is None else {**record, "fingerprint": mark}
