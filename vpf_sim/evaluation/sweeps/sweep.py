"""A sweep: drive the missing episodes of a plan with worker processes, into a run folder."""

import os
import platform
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from functools import partial
from math import isfinite
from pathlib import Path
from traceback import format_exc
from typing import Any

from vpf_sim import scenarios
from vpf_sim.errors import InputError, option
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics import records
from vpf_sim.evaluation.processes import pool
from vpf_sim.evaluation.sweeps.fingerprint import fingerprint
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder

Stored = tuple[dict[str, Any], dict[str, Any]]  # record, timing
Limit = Callable[[Job], float]  # s of wall time
Results = Generator[pool.Done[Job, Stored], None, None]
START_S = 60.0  # to import, and to score
SLOWEST = 6.0  # times slower than the simulated clock: 10 steps a second
LONGEST_S = 1e6  # a watchdog accepts no longer limit


def local(folder: RunFolder, jobs: Iterable[Job], workers: int, limit_s: Limit) -> Results:
    """Drive on this machine; the workers store the steps."""
    return pool.run(partial(drive_and_store, folder.path, folder.mark, folder.asked), jobs, workers, limit_s)


def here(folder: RunFolder, jobs: Iterable[Job]) -> Results:
    """Drive in this process, one after another, without a time limit: for drivers that no other process can import."""
    return pool.here(partial(drive_and_store, folder.path, folder.mark, folder.asked), jobs)


def store(
    folder: RunFolder, results: Iterable[pool.Done[Job, Stored]], notify: Callable[[dict[str, Any]], None]
) -> None:
    """Store results as they arrive; `notify` is called with each record."""
    for done in results:
        record, timing = done.result or given_up(done.task, folder.mark, done.reason)
        timing |= {"worker": done.worker, "retries": done.attempts - 1}
        folder.add(record, timing)
        notify(record)


def limits(timeout_s: float | None) -> Limit:
    """The wall-time limit of an episode: as given, or the scenario's limit on a slow machine."""
    if timeout_s is None:
        return _slow_s
    if not isfinite(timeout_s) or not 0.0 < timeout_s <= LONGEST_S:
        raise InputError(
            f"{option('timeout')}: expected seconds, more than 0 and up to {LONGEST_S:.0f}, got {timeout_s:g}"
        )
    return lambda _: timeout_s


def _slow_s(job: Job) -> float:
    return START_S + SLOWEST * scenarios.load(job.scenario).draw(job.seed).time_limit_s


def drive_and_store(folder: Path, mark: str | None, asked: dict[str, Any], job: Job) -> Stored:
    """Drive one episode, store its steps, and return record and timing; an exception becomes status `error`.

    InputError if code or input files changed since the sweep began: a worker that replaces a dead one would load the
    edited files.
    """
    changed = [*changes(asked, job)]
    if changed:
        raise InputError(f"{', '.join(changed)}: changed while the sweep was running")
    record, timing, table = drive(mark, job)
    if table is not None:
        steps.write(table, folder / "steps" / f"{job.id}.parquet")
    return record, timing


def changes(asked: Mapping[str, Any], job: Job) -> Iterator[str]:
    """Names of fingerprint entries and inputs that differ from the manifest."""
    own = fingerprint()
    yield from (key for key in own if own[key] != asked["fingerprint"].get(key))
    for kind, hashes in Plan.of(job).hashes().items():
        yield from (name for name, value in hashes.items() if asked.get(kind, {}).get(name) != value)


def drive(mark: str | None, job: Job) -> tuple[dict[str, Any], dict[str, Any], steps.StepTable | None]:
    """Drive one episode: record, timing and steps."""
    from vpf_sim.evaluation.episode import episode

    try:
        result = episode.run(*job)
    except Exception:
        return *given_up(job, mark, format_exc()), None
    timing = {**result.timing, "host": platform.node(), "process": os.getpid()}
    return marked(result.record, mark), timing, result.steps


def default_workers() -> int:
    """The number of cores that this process may use; 1 if it may start no other processes."""
    if not pool.may_start():
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def given_up(job: Job, mark: str | None, reason: str) -> Stored:
    """Record and timing of an episode without a result."""
    return marked(records.failed(job), mark), {"id": job.id, "traceback": reason, "host": platform.node()}


def marked(record: dict[str, Any], mark: str | None) -> dict[str, Any]:
    """The record, with the fingerprint's digest if it differs from the run's."""
    return record if mark is None else {**record, "fingerprint": mark}
