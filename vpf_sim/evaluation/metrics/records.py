"""The record of an episode and its timing: how a run folder stores them, and how they are read again.

Records of earlier versions are read, too: scores that they lack are missing, keys that this version does not know are
kept as they are. nan and inf are stored as None.
"""

import json
from collections.abc import Callable, Mapping
from hashlib import sha256
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, SkipValidation, ValidationError

from vpf_sim.errors import InputError, shown, wrong_value
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.failure import Failure, failure_of
from vpf_sim.evaluation.metrics.metric import Driven, Metric
from vpf_sim.evaluation.metrics.registry import MEASURES, TABLES, collision_type
from vpf_sim.evaluation.score_keys import Json, Number, finite, flat, nested
from vpf_sim.evaluation.steps import InvalidFrame, Outcome
from vpf_sim.types import Floats


class Schema(BaseModel):
    """What a file of a run folder holds; no value is converted, unknown keys are ignored."""

    model_config = ConfigDict(frozen=True, strict=True, allow_inf_nan=False)


class Record(Schema):
    """One episode: what was driven, how it ended, and its scores by dotted key."""

    id: str
    scenario: str
    weather: str
    driver: str
    seed: int
    status: str
    steps: int
    scores: SkipValidation[dict[str, Number]]  # by dotted key
    invalid_frame: InvalidFrame | None = None
    collided_with: str | None = None
    collision_type: str | None = None
    failure: Failure | None = None  # why it failed
    states_sha256: str | None = None
    frames_sha256: str | None = None  # None where the driver uses no frames
    fingerprint: str | None = None  # digest of the version that made it, if it is not the run's
    unknown: Json = {}  # keys of other versions

    @property
    def job(self) -> Job:
        return Job(self.scenario, self.weather, self.driver, self.seed)

    @property
    def cell(self) -> tuple[str, str, str]:
        return self.scenario, self.weather, self.driver

    @property
    def succeeded(self) -> bool:
        return self.status == "success"

    @property
    def ending(self) -> str:
        """How the episode ended, as text: "collision with a car"."""
        hit = f" with a {self.collided_with}" if self.collided_with else ""
        return f"{self.status.replace('_', ' ')}{hit}"

    @property
    def shows_perception(self) -> bool:
        """Whether anything of the driver's perception was scored."""
        return any(key.startswith("perception.") for key in self.scores)

    def __getitem__(self, metric: Metric) -> Number:
        """The value of a metric; None where it was not measured."""
        return self.scores.get(metric.key)

    def marked(self, fingerprint: str | None) -> "Record":
        """The record with the digest of another version's fingerprint, if there is one."""
        return self if fingerprint is None else self.model_copy(update={"fingerprint": fingerprint})

    def as_json(self) -> Json:
        """The line of episodes.jsonl."""
        own = self.model_dump(exclude={"scores", "unknown"})
        if self.fingerprint is None:
            del own["fingerprint"]
        return {**own, **nested(self.scores), **self.unknown}


_SCORED = {measure.key for measure in MEASURES}
_TABLES = [table.key for table in TABLES]
_OWN = Record.model_fields.keys() - {"scores", "unknown"}


class Timing(Schema):
    """A line of timing.jsonl: wall times of an episode."""

    id: str
    wall_s: Number = None
    steps_per_s: Number = None
    stages_ms: dict[str, float] = {}
    host: str = ""
    process: int | None = None
    worker: int | str | None = None
    retries: int = 0

    def as_json(self) -> Json:
        return self.model_dump(exclude_unset=True)


def read_record(row: Json, file: str) -> Record:
    """The record of a line of `file`; InputError in one line where it is none."""
    if "id" not in row:
        raise InputError(f"{file}: expected a record with an id on each line, got a line without")
    try:
        values = flat({key: row[key] for key in row.keys() & _SCORED})
        if wrong := next((key for key in _TABLES if values.get(key) is not None), None):
            raise ValueError(f"{wrong}: expected a table of numbers, got {shown(values[wrong])}")
    except ValueError as error:
        raise InputError(f"{file}: {short(row['id'])}: {error}") from None
    own: Json = {key: row[key] for key in row.keys() & _OWN}
    own |= {"scores": values, "unknown": {key: row[key] for key in row.keys() - _SCORED - _OWN}}
    record = checked(Record, own, lambda: f"{file}: {short(row['id'])}")
    if (expected := record.job.id) != record.id:
        where = f"{file}: {short(row['id'])}"
        raise InputError(f"{where}: expected the id of its scenario, weather, driver and seed, which is {expected}")
    return record


Checked = TypeVar("Checked", bound=BaseModel)


def checked(schema: type[Checked], value: Mapping[str, object], where: str | Callable[[], str]) -> Checked:
    """The value validated by a schema; InputError with `where` and the first fault in one line."""
    try:
        return schema.model_validate(value)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join(map(str, fault["loc"]))
        message = str(fault["msg"]).removeprefix("Value error, ")
        got = f"{key}: {wrong_value(message, fault['input'])}"
        place = where if isinstance(where, str) else where()
        raise InputError(f"{place}: " + (f"key '{key}' is missing" if fault["type"] == "missing" else got)) from None


def short(value: object) -> str:
    """A value as JSON, of at most 80 characters."""
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def record_of(job: Job, outcome: Outcome, route: Floats, route_length_m: float) -> Record:
    """The record of an episode; `route` has waypoints (M, 2) from the start to beyond the goal at `route_length_m`."""
    if len(outcome.steps) == 0:
        return unscored(job, outcome.status, outcome.invalid_frame)
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


def unscored(job: Job, status: str = "error", invalid_frame: InvalidFrame | None = None) -> Record:
    """The record of an episode without scores: it never began, or its worker died."""
    scores = {measure.key: measure.unmeasured for measure in MEASURES}
    return Record(id=job.id, **job._asdict(), status=status, steps=0, scores=scores, invalid_frame=invalid_frame)
