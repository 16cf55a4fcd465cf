"""Scores an episode: its record is a function of scenario, weather, driver, seed and fingerprint."""

from hashlib import sha256

from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.failure import failure_of
from vpf_sim.evaluation.metrics.metric import Driven
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import MEASURES, collision_type
from vpf_sim.evaluation.scores import finite, flat
from vpf_sim.evaluation.steps import InvalidFrame, Outcome
from vpf_sim.types import Floats


def score(job: Job, outcome: Outcome, route: Floats, route_length_m: float) -> Record:
    """The record of an episode; `route` has waypoints (M, 2) from the start to beyond the goal at `route_length_m`."""
    if len(outcome.steps) == 0:
        return failed(job, outcome.status, outcome.invalid_frame)
    driven = Driven(outcome, route, route_length_m)
    measured = {measure.key: measure.of(driven) for measure in MEASURES if measure.of is not None}
    return Record(
        id=job.id,
        **job._asdict(),
        status=outcome.status,
        steps=len(outcome.steps),
        scores=flat(finite(measured)),
        invalid_frame=outcome.invalid_frame,
        collided_with=outcome.collided_with,
        collision_type=collision_type(driven),
        failure=failure_of(outcome),
        states_sha256=sha256(outcome.steps.states()).hexdigest(),
        frames_sha256=outcome.frames_sha256,
    )


def failed(job: Job, status: str = "error", invalid_frame: InvalidFrame | None = None) -> Record:
    """The record of an episode without scores: it never began, or its worker died."""
    scores = {measure.key: measure.unmeasured for measure in MEASURES}
    return Record(id=job.id, **job._asdict(), status=status, steps=0, scores=scores, invalid_frame=invalid_frame)
