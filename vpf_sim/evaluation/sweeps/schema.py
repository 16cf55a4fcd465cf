"""Schemas of the files in a run folder, which may be incomplete, edited, or of another version.

Unknown keys are ignored; nan and inf are stored as None.
"""

from collections.abc import Mapping
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, PositiveInt, ValidationError, field_validator

from vpf_sim.errors import InputError, wrong_value

Number = float | None
Numbers = dict[str, Number]


class Schema(BaseModel):
    """Strict: no value is converted."""

    model_config = ConfigDict(frozen=True, strict=True, allow_inf_nan=False)


class Signals(Schema):
    throttle: Numbers | None = None
    steering: Numbers | None = None


class Protocol(Signals):
    clear_of_obstacles: Signals | None = None
    passing: Signals | None = None


class Accuracies(Schema):
    shadow: Protocol | None = None
    paired: Protocol | None = None


class Bounded(Schema):
    min: Number = None
    max: Number = None
    within: bool | None = None


class Comfort(Schema):
    comfortable: bool | None = None
    signals: dict[str, Bounded] | None = None
    min_ttc_s: Number = None


class Perception(Schema):
    foe_median_error_px: Numbers | None = None
    foe_share: Number = None
    edge_error_10m_m: Numbers | None = None
    flow_median_error_px: Number = None
    ttc_median_error: Number = None
    objects: Numbers | None = None


class Scores(Schema):
    """Scores of a record, or their means in a row."""

    path_mse_m2: Number
    path_mse_parts_m2: Numbers | None = None
    max_lane_offset_m: Number = None
    min_clearance_m: Number = None
    accuracy: Accuracies | None = None
    chattering: dict[str, Numbers] | None = None
    perception: Perception | None = None


class Record(Scores):
    """A line of episodes.jsonl."""

    id: str
    scenario: str
    weather: str
    driver: str
    seed: int
    status: str
    invalid_frame: dict[str, Any] | None
    route_completion: float
    driving_score_2_0: float
    driving_score_2_1: float
    comfort: Comfort | None
    collisions: int
    at_fault_collisions: int
    collided_with: str | None
    collision_type: str | None
    steps: int
    states_sha256: str | None
    frames_sha256: str | None


class Timing(Schema):
    """A line of timing.jsonl."""

    id: str
    wall_s: Number = None
    steps_per_s: Number = None
    stages_ms: dict[str, float] = {}
    host: str = ""
    retries: int = 0


class Manifest(Schema):
    """The required keys of manifest.json."""

    command: str
    plan: dict[str, Any]
    fingerprint: dict[str, str]
    scenarios: dict[str, str]
    weathers: dict[str, str]
    drivers: dict[str, str] = {}
    privileged: dict[str, str] = {}
    begun: str | None = None  # ISO 8601
    made_in: str | None = None  # the working folder


class Paper(Schema):
    path_mse_m2: float
    throttle: float
    steering: float


class Row(Scores):
    """A cell's row of summary.json."""

    scenario: str
    weather: str
    driver: str
    privileged: str
    episodes: PositiveInt
    successes: int
    success_rate: float
    statuses: dict[str, int]
    least_clearance_m: Number = None
    comfortable_share: Number = None
    driving_score_2_1: Number = None
    intervals: dict[str, Any] = {}
    seeds_needed: dict[str, int | None] = {}
    unsuccessful: Scores | None = None
    paper: Paper | None = None

    @field_validator("intervals")
    @classmethod
    def _ends(cls, value: dict[str, Any]) -> dict[str, Any]:
        if not _are_ends(value):
            raise ValueError("two numbers for each interval")
        return value


class Difference(Schema):
    difference: float
    interval: list[float] | None
    p: float
    pairs: int


class Comparison(Schema):
    """A difference of two cells in summary.json; its extra keys are scores."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Difference | None]

    of: Literal["weather", "driver"]
    scenario: str
    weather: str
    driver: str
    minus: str


class Summary(Schema):
    rows: list[Row]
    comparisons: list[Comparison] = []


Checked = TypeVar("Checked", bound=BaseModel)


def checked(schema: type[Checked], value: Mapping[str, Any], where: str) -> Checked:
    """The value validated by a schema; InputError with `where` and the first fault in one line."""
    try:
        return schema.model_validate(value)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join(map(str, fault["loc"]))
        got = f"key '{key}' is missing" if fault["type"] == "missing" else f"{key}: {_wrong(fault)}"
        raise InputError(f"{where}: {got}") from None


def _wrong(fault: Mapping[str, Any]) -> str:
    return wrong_value(str(fault["msg"]).removeprefix("Value error, "), fault["input"])


def _are_ends(value: object) -> bool:
    """Whether the value is [low, high], None, or a table of these."""
    if isinstance(value, dict):
        return all(map(_are_ends, value.values()))
    if isinstance(value, list):
        return len(value) == 2 and all(isinstance(end, int | float) for end in value)
    return value is None
