"""What a run folder says, held against itself: its plan, its steps, its scores and its summary.

Nothing is driven. Every stored episode is checked; one that will be driven again needs no stored steps.
"""

from collections import Counter
from collections.abc import Collection, Iterator
from hashlib import sha256

from vpf_sim.envs.ending import STANDING_MPS
from vpf_sim.envs.world import build_route
from vpf_sim.errors import InputError
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.analysis.rescore import score
from vpf_sim.evaluation.analysis.summary import summarize
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.tracking import completion
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.steps import Outcome, StepTable
from vpf_sim.evaluation.sweeps.manifest import HASHED
from vpf_sim.evaluation.verification.mismatch import Mismatch
from vpf_sim.evaluation.verification.run import Run

WHOLE = 0.98  # share of the route, in its own steps, of an episode that reached a goal
EDITED = "an edited record"
REMOVED = "removed steps, without which every episode has to be driven again (--share 1)"


def mismatches(run: Run, driven: Collection[str] = ()) -> Iterator[Mismatch]:
    """Everything in the folder that contradicts the rest of it; `driven` are the episodes to be driven again."""
    yield from _plan(run)
    yield from _inputs(run)
    for record in run.records:
        yield from _record(run, record, needs_steps=record.id not in driven)
    yield from _summary(run)


def _plan(run: Run) -> Iterator[Mismatch]:
    """Each planned episode has one record, and there are no others."""
    counts = Counter(record.id for record in run.records)
    for job in run.jobs:
        if counts[job.id] != 1:
            cause = "an interrupted run, or episodes were left out" if not counts[job.id] else EDITED
            yield Mismatch(job.id, None, "records of a planned episode", counts[job.id], 1, cause)
    planned = {job.id for job in run.jobs}
    for name in counts.keys() - planned:
        yield Mismatch(name, None, "planned", True, False, "a record of another run, or an edited plan")


def _inputs(run: Run) -> Iterator[Mismatch]:
    """Scenarios, weathers and drivers are those that the run was made with."""
    now = run.plan.hashes(run.inputs)
    for kind in HASHED:
        for name in sorted(now[kind].keys() | run.manifest.hashes(kind).keys()):
            before, after = run.manifest.hashes(kind).get(name), now[kind].get(name)
            if before != after:
                cause = (
                    "other code or weights" if kind == "drivers" else "an edited file, or another version of vpf_sim"
                )
                yield Mismatch("", None, f"{kind[:-1]} {name}", before, after, cause)


def _record(run: Run, record: Record, needs_steps: bool) -> Iterator[Mismatch]:
    """The scores of a record follow from its steps, and its ending is possible after them."""
    file = run.steps_file(record.id)
    if record.states_sha256 is None or not (needs_steps or file.exists()):
        return
    try:
        table = steps.read(file)
    except InputError as error:
        yield Mismatch(record.id, None, "steps", "a file", str(error), REMOVED)
        return
    found = sha256(table.states()).hexdigest()
    if found != record.states_sha256:
        yield Mismatch(record.id, None, "states", record.states_sha256, found, f"{EDITED}, or edited steps")
        return
    outcome = Outcome(
        record.status, table, record.collided_with, record.frames_sha256, invalid_frame=record.invalid_frame
    )
    again = score(record.job, outcome, run.inputs).marked(record.fingerprint)
    yield from differing(record, again, f"{EDITED}: its scores do not follow from its steps")
    yield from _ending(run, record, table)


def differing(stored: Record, found: Record, cause: str) -> Iterator[Mismatch]:
    """The keys of two records that differ."""
    before, after = _flat(stored), _flat(found)
    for key in sorted(before.keys() | after.keys()):
        if before.get(key) != after.get(key):
            yield Mismatch(stored.id, None, key, before.get(key), after.get(key), cause)


def _flat(record: Record) -> Json:
    return {**record.model_dump(exclude={"scores", "unknown", "fingerprint"}), **record.scores}


def _ending(run: Run, record: Record, table: StepTable) -> Iterator[Mismatch]:
    """A success is at the goal, or stands before what it was to stop at."""
    if not record.succeeded:
        return
    scenario = run.inputs.scenario(record.scenario).draw(record.seed)
    if scenario.goal.kind == "reach":
        share = completion(table.route_m, build_route(scenario, record.seed).length_m)
        if share < WHOLE:
            yield Mismatch(record.id, len(table), "status", "success", f"{share:.1%} of the route", EDITED)
    elif table.speed_mps[-1] >= STANDING_MPS:
        yield Mismatch(record.id, len(table), "status", "success", f"{table.speed_mps[-1]:.2f} m/s", EDITED)


def _summary(run: Run) -> Iterator[Mismatch]:
    """The summary follows from the records."""
    stored = run.summary
    if stored is None:
        return
    again = summarize(run.jobs, run.records, run.manifest.privileged)
    for before, after in zip(stored.rows, again.rows, strict=False):
        for key in sorted(before.scores.keys() | after.scores.keys()):
            if before.scores.get(key) != after.scores.get(key):
                where = f"summary.json: {', '.join(before.cell)}: {key}"
                yield Mismatch("", None, where, before.scores.get(key), after.scores.get(key), "an edited summary")
    if stored.as_json() != again.as_json():
        yield Mismatch("", None, "summary.json", "its content", "another one", "an edited summary")
