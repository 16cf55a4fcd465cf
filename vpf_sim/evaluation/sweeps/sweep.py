"""A sweep: drive the missing episodes of a plan with worker processes, into a run folder."""

import os
import platform
from collections.abc import Callable, Generator, Iterable, Iterator
from functools import partial
from math import isfinite
from pathlib import Path
from traceback import format_exc
from typing import NamedTuple

from vpf_sim import scenarios
from vpf_sim.errors import InputError, option
from vpf_sim.evaluation import pool, steps
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, Timing, unscored
from vpf_sim.evaluation.sweeps.fingerprint import fingerprint
from vpf_sim.evaluation.sweeps.manifest import HASHED, Manifest
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder


class Stored(NamedTuple):
    """What a run folder stores of an episode beside its steps."""

    record: Record
    timing: Timing
    traceback: str | None = None  # of an error


Limit = Callable[[Job], float]  # s of wall time
Results = Generator[pool.Done[Job, Stored], None, None]
START_S = 60.0  # to import, and to score
SLOWEST = 6.0  # times slower than the simulated clock: 10 steps a second
LONGEST_S = 1e6  # a watchdog accepts no longer limit


def local(folder: RunFolder, jobs: Iterable[Job], workers: int, limit_s: Limit) -> Results:
    """Drive on this machine; the workers store the steps."""
    return pool.run(partial(drive_and_store, folder.path, folder.mark, folder.requested), jobs, workers, limit_s)


def here(folder: RunFolder, jobs: Iterable[Job]) -> Results:
    """Drive in this process, one after another, without a time limit: for drivers that no other process can import."""
    return pool.here(partial(drive_and_store, folder.path, folder.mark, folder.requested), jobs)


def store(folder: RunFolder, results: Iterable[pool.Done[Job, Stored]], notify: Callable[[Record], None]) -> None:
    """Store results as they arrive; `notify` is called with each record."""
    for done in results:
        record, timing, traceback = done.result or given_up(done.task, folder.mark, done.reason)
        by = {"worker": done.worker, "retries": done.attempts - 1}
        folder.add(record, timing.model_copy(update=by), traceback)
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


def drive_and_store(folder: Path, mark: str | None, requested: Manifest, job: Job) -> Stored:
    """Drive one episode, store its steps, and return what else is stored; an exception becomes status `error`.

    InputError if code or input files changed since the sweep began: a worker that replaces a dead one would load the
    edited files.
    """
    changed = [*changes(requested, job)]
    if changed:
        raise InputError(f"{', '.join(changed)}: changed while the sweep was running")
    stored, table = drive(mark, job)
    if table is not None:
        steps.write(table, folder / "steps" / f"{job.id}.parquet")
    return stored


def changes(requested: Manifest, job: Job) -> Iterator[str]:
    """Names of fingerprint entries and inputs that differ from the manifest."""
    own, inputs = fingerprint(), Plan.of(job).hashes()
    yield from (key for key in own if own[key] != requested.fingerprint.get(key))
    for kind in HASHED:
        yield from (name for name, value in inputs[kind].items() if requested.hashes(kind).get(name) != value)


def drive(mark: str | None, job: Job) -> tuple[Stored, steps.StepTable | None]:
    """Drive one episode: what is stored of it, and its steps."""
    from vpf_sim.evaluation.episode import episode

    try:
        result = episode.run(*job)
    except Exception:
        return given_up(job, mark, format_exc()), None
    timing = result.timing.model_copy(update={"host": platform.node(), "process": os.getpid()})
    return Stored(result.record.marked(mark), timing, result.traceback), result.steps


def default_workers() -> int:
    """The number of cores that this process may use; 1 if it may start no other processes."""
    if not pool.may_start():
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def given_up(job: Job, mark: str | None, reason: str) -> Stored:
    """What is stored of an episode without a result; its record is marked where the version is not the run's."""
    return Stored(unscored(job).marked(mark), Timing(id=job.id, host=platform.node()), reason)
