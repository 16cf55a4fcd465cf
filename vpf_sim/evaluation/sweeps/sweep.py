"""A sweep: the planned episodes over worker processes into a run folder, from the start or from where it was left."""

import os
import platform
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from functools import partial
from math import isfinite
from pathlib import Path
from traceback import format_exc
from typing import Any

from vpf_sim import scenarios
from vpf_sim.errors import InputError
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
START_S = 60.0  # to load all, and to score
SLOWEST = 6.0  # times slower than the simulated clock: 10 steps a second
LONGEST_S = 1e6  # beyond it the clock of a watchdog would not reach


def local(folder: RunFolder, jobs: Iterable[Job], workers: int, limit_s: Limit) -> Results:
    """Drive on this machine, and store the steps."""
    return pool.run(partial(drive_and_store, folder.path, folder.mark, folder.asked), jobs, workers, limit_s)


def store(folder: RunFolder, results: Iterable[pool.Done[Job, Stored]], tell: Callable[[dict[str, Any]], None]) -> None:
    """Keep what comes; `tell` hears of each record as it is stored."""
    for done in results:
        record, timing = done.result or given_up(done.task, folder.mark, done.reason)
        timing |= {"worker": done.worker, "retries": done.attempts - 1}
        folder.add(record, timing)
        tell(record)


def limits(timeout_s: float | None) -> Limit:
    """How long an episode may take: what is asked for, or what the scenario's own limit takes on a slow machine."""
    if timeout_s is None:
        return _slow_s
    if not isfinite(timeout_s) or not 0.0 < timeout_s <= LONGEST_S:
        raise InputError(f"--timeout: expected seconds, more than 0 and up to {LONGEST_S:.0f}, got {timeout_s:g}")
    return lambda _: timeout_s


def _slow_s(job: Job) -> float:
    return START_S + SLOWEST * scenarios.load(job.scenario).draw(job.seed).time_limit_s


def drive_and_store(folder: Path, mark: str | None, asked: dict[str, Any], job: Job) -> Stored:
    """Drive one episode, store its steps, and give its record and timing; whatever goes wrong in it is an `error`.

    InputError if anything is no longer as it was when the sweep was asked for: files may be edited meanwhile, and a
    worker that is started in the place of one that died reads the code as it is then.
    """
    changed = [*changes(asked, job)]
    if changed:
        raise InputError(f"{', '.join(changed)}: changed while the sweep was running")
    record, timing, table = drive(mark, job)
    if table is not None:
        steps.write(table, folder / "steps" / f"{job.id}.parquet")
    return record, timing


def changes(asked: Mapping[str, Any], job: Job) -> Iterator[str]:
    """What an episode depends on that says something else here than in the manifest."""
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
    """One a core that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def given_up(job: Job, mark: str | None, reason: str) -> Stored:
    """What is stored of an episode without a result."""
    return marked(records.failed(job), mark), {"id": job.id, "traceback": reason, "host": platform.node()}


def marked(record: dict[str, Any], mark: str | None) -> dict[str, Any]:
    """A record made on another fingerprint than the run's says so."""
    return record if mark is None else {**record, "fingerprint": mark}
