"""Episodes of a stored run, driven again: states, commands, frames and scores must be equal to the bit."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import ceil
from pathlib import Path

import numpy as np

from vpf_sim.drivers import KEYBOARD
from vpf_sim.evaluation import pool, steps
from vpf_sim.evaluation.episode import episode
from vpf_sim.evaluation.episode.episode import EpisodeResult
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.sweeps.fingerprint import fingerprint
from vpf_sim.evaluation.verification.claims import EDITED, differing
from vpf_sim.evaluation.verification.mismatch import Mismatch, other_maker
from vpf_sim.evaluation.verification.run import Run
from vpf_sim.seeding import stream

MOVED = ("time_s", "x_m", "y_m", "yaw_rad", "speed_mps", "yaw_rate_radps")  # what the world does
DECIDED = "other weights or code of the driver, or chance in it that no seed repeats"
LOST = "its worker was lost or out of time when the run was made"
Driven = pool.Done[Job, Mismatch | None]


def sample(jobs: Sequence[Job], share: float, seed: int) -> list[Job]:
    """A random share of the episodes, at least one, in their order; a person drives none twice."""
    jobs = [job for job in jobs if job.driver != KEYBOARD]
    count = min(len(jobs), max(1, ceil(share * len(jobs))))
    chosen = stream(seed, "verify").choice(len(jobs), count, replace=False)
    return [jobs[i] for i in sorted(chosen)]


def drive(run: Run, jobs: Sequence[Job], workers: int) -> Iterator[Driven]:
    """Drive episodes again; the result of each is its first difference, or None."""
    return pool.run(partial(first_difference, run.path), jobs, workers)


def first_difference(path: Path, job: Job) -> Mismatch | None:
    """Drive one stored episode again, and compare."""
    run = Run.of(path)
    (record,) = (one for one in run.records if one.id == job.id)
    found = _driven(run.inputs, job)
    other = other_maker(run.manifest, record, fingerprint())
    if record.states_sha256 is not None and len(found.steps) and run.steps_file(record.id).exists():
        stored = steps.read(run.steps_file(record.id))
        if (place := _first_place(stored, found.steps)) is not None:
            row, name = place
            before, after = (float(getattr(table, name)[row]) for table in (stored, found.steps))
            cause = other or (f"edited steps and {EDITED}" if name in MOVED else DECIDED)
            return Mismatch(record.id, row, name, before, after, cause)
        if len(stored) != len(found.steps):
            cause = other or (DECIDED if len(found.steps) < len(stored) else f"{EDITED}, cut short")
            return Mismatch(record.id, None, "steps", len(stored), len(found.steps), cause)
    cause = other or (LOST if record.status == "error" else EDITED)
    return next(differing(record, found.record, cause), None)


def _driven(inputs: RunInputs, job: Job) -> EpisodeResult:
    return episode.run(job.scenario, job.weather, inputs.driver(job.driver), job.seed, name=job.driver, inputs=inputs)


def _first_place(stored: StepTable, found: StepTable) -> tuple[int, str] | None:
    """Row and column of the first different value, the world's before the driver's; None where all are equal."""
    rows = min(len(stored.rows), len(found.rows))
    before, after = stored.rows[:rows], found.rows[:rows]
    differ = (before != after) & ~(np.isnan(before) & np.isnan(after))
    if not differ.any():
        return None
    row = int(np.flatnonzero(differ.any(axis=1))[0])
    names = [Step._fields[i] for i in np.flatnonzero(differ[row])]
    return row, next((name for name in names if name in MOVED), names[0])
