"""The rules of the gate, read from a TOML file; each rule applies to some cells or all."""

from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from vpf_sim import tables
from vpf_sim.errors import InputError, wrong_value

Score = Literal["success_rate", "collisions", "path_mse_m2", "clearance_m", "comfortable_share"]
SCORES: tuple[Score, ...] = get_args(Score)
Share = Annotated[float, Field(ge=0.0, le=1.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


class Section(BaseModel):
    """Strict: no unknown keys, no conversion of values."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class PerceptionBounds(Section):
    """Bounds on perception metrics; bounds on errors are on the median, with _p95 on the 95th percentile."""

    recall_at_least: Share | None = None
    precision_at_least: Share | None = None
    false_positives_per_minute_at_most: NotNegative | None = None
    distance_error_m_at_most: NotNegative | None = None
    distance_error_m_p95_at_most: NotNegative | None = None
    left_error_m_at_most: NotNegative | None = None
    left_error_m_p95_at_most: NotNegative | None = None
    right_error_m_at_most: NotNegative | None = None
    right_error_m_p95_at_most: NotNegative | None = None
    speed_error_mps_at_most: NotNegative | None = None
    speed_error_mps_p95_at_most: NotNegative | None = None
    edge_error_m_at_most: NotNegative | None = None
    edge_error_m_p95_at_most: NotNegative | None = None
    lane_error_m_at_most: NotNegative | None = None
    lane_error_m_p95_at_most: NotNegative | None = None
    foe_error_px_at_most: NotNegative | None = None
    foe_error_px_p95_at_most: NotNegative | None = None

    def bounds(self) -> dict[str, float]:
        """The given bounds by key."""
        return {key: limit for key in PerceptionBounds.model_fields if (limit := getattr(self, key)) is not None}


class Rule(Section):
    """Bounds for the cells that match `scenario`, `weather` and `driver`; "*" and "?" are wildcards."""

    scenario: str = "*"
    weather: str = "*"
    driver: str = "*"
    success_rate_at_least: Share | None = None
    collisions_at_most: Annotated[int, Field(ge=0)] | None = None
    path_mse_m2_at_most: NotNegative | None = None
    path_mse_m2_upper_at_most: NotNegative | None = None  # the upper end of the mean's 95 % interval
    clearance_m_at_least: NotNegative | None = None
    comfortable_share_at_least: Share | None = None
    perception: PerceptionBounds | None = None
    no_worse_than: str | None = None  # a run folder or summary.json, relative to the rules file
    scores: list[Score] = list(SCORES)  # compared by no_worse_than

    def bounds(self) -> dict[str, float]:
        """The given bounds by key."""
        return {key: getattr(self, key) for key in BOUNDS if getattr(self, key) is not None}


BOUNDS = tuple(key for key in Rule.model_fields if key.endswith(("_at_least", "_at_most")))


class Rules(Section):
    rules: list[Rule] = []


def read_rules(path: Path) -> list[Rule]:
    """The rules of a file; InputError with one line per fault."""
    content = tables.read_file(path, "rules")
    try:
        rules = Rules.model_validate(content).rules
    except ValidationError as error:
        faults = error.errors(include_url=False)
        raise InputError("\n".join(f"{path}: {_line(dict(fault))}" for fault in faults)) from None
    empty = list(_empty(rules))
    if empty:
        raise InputError("\n".join(f"{path}: {fault}" for fault in empty))
    return rules


def _empty(rules: list[Rule]) -> Iterator[str]:
    """One line per rule without bounds, which would always pass."""
    if not rules:
        yield "rules: expected at least one [[rules]], got none"
    for i, rule in enumerate(rules):
        if rule.perception is not None and not rule.perception.bounds():
            yield f"rules[{i}].perception: expected a bound, such as recall_at_least, got none"
        if not rule.bounds() and rule.no_worse_than is None and rule.perception is None:
            yield f"rules[{i}]: expected a bound, such as {BOUNDS[0]}, or no_worse_than, got none"
        if "scores" in rule.model_fields_set and (rule.no_worse_than is None or not rule.scores):
            yield f"rules[{i}].scores: expected some scores, and no_worse_than beside them"


def _line(fault: dict[str, Any]) -> str:
    """A pydantic fault in one line, with the key as in the file and the nearest known name."""
    location: tuple[int | str, ...] = fault["loc"]
    key = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in location).removeprefix(".")
    if fault["type"] == "extra_forbidden":
        sections: dict[int, type[Section]] = {1: Rules, 3: Rule, 4: PerceptionBounds}
        known = list(sections[len(location)].model_fields)
        near = get_close_matches(str(location[-1]), known, n=1, cutoff=0.5)
        return f"{key}: unknown key, " + (f"did you mean '{near[0]}'?" if near else f"known: {', '.join(known)}")
    if fault["type"] == "model_type":
        return f"{key}: expected a table, got {fault['input']!r}"
    near = get_close_matches(str(fault["input"]), SCORES, n=1, cutoff=0.5) if fault["type"] == "literal_error" else []
    return f"{key}: {wrong_value(fault['msg'], fault['input'])}" + "".join(f": did you mean '{one}'?" for one in near)
