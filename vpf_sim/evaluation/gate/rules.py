"""The rules of the gate, read from a TOML file; each rule applies to some cells or all."""

from collections.abc import Iterable
from dataclasses import fields
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Literal, get_args

from pydantic import Field

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.evaluation.analysis.rows import Cell

DEFAULT_RULES = Path(__file__).with_name("default_rules.toml")  # for the scenarios gate-course and gate-traffic
Score = Literal["success_rate", "collisions", "path_mse_m2", "clearance_m", "comfortable_share"]
SCORES: tuple[Score, ...] = get_args(Score)
Share = Annotated[float, Field(ge=0.0, le=1.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


@settings
class PerceptionBounds:
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

    def __post_init__(self) -> None:
        if not self.bounds():
            raise ValueError("expected a bound, such as recall_at_least, got none")

    def bounds(self) -> dict[str, float]:
        """The given bounds by key."""
        return _given(self, [field.name for field in fields(self)])


@settings
class Rule:
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
    clear_path_mse_m2_at_most: NotNegative | None = None  # of the route without obstacles, as the next ones a mean
    steering_rate_radps_at_most: NotNegative | None = None  # the 95th percentile of an episode
    steering_reversals_per_s_at_most: NotNegative | None = None
    edge_error_m_at_most: NotNegative | None = None  # perception while driving, of drivers that show it
    foe_error_px_at_most: NotNegative | None = None
    recall_at_least: Share | None = None
    precision_at_least: Share | None = None
    false_positives_per_minute_at_most: NotNegative | None = None
    perception: PerceptionBounds | None = None
    no_worse_than: str | None = setting(
        "Run folder or summary.json of a baseline, relative to the rules file.", default=None
    )
    scores: tuple[Score, ...] | None = setting(
        "Scores that `no_worse_than` compares; all by default.", default=None, min_length=1
    )

    def __post_init__(self) -> None:
        if not self.bounds() and self.no_worse_than is None and self.perception is None:
            raise ValueError(f"expected a bound, such as {BOUNDS[0]}, or no_worse_than, got none")
        if self.scores is not None and self.no_worse_than is None:
            raise ValueError("scores: expected no_worse_than beside them, got none")

    def bounds(self) -> dict[str, float]:
        """The given bounds by key."""
        return _given(self, BOUNDS)

    def matches(self, cell: Cell) -> bool:
        """Whether the rule is for a cell."""
        return all(map(fnmatchcase, cell, (self.scenario, self.weather, self.driver)))


BOUNDS = tuple(key for field in fields(Rule) if (key := field.name).endswith(("_at_least", "_at_most")))


@settings
class Rules:
    rules: tuple[Rule, ...] = setting("Rules, each for the cells that it names.", min_length=1)


def read_rules(path: Path) -> list[Rule]:
    """The rules of a file; InputError with one line per fault."""
    return list(configuration.build(Rules, configuration.read_file(path, "rules"), str(path)).rules)


def score_of(bound: str) -> str:
    """The score that a bound limits: "path_mse_m2" of "path_mse_m2_upper_at_most"."""
    return bound.removesuffix("_at_least").removesuffix("_at_most").removesuffix("_upper")


def _given(bounds: PerceptionBounds | Rule, keys: Iterable[str]) -> dict[str, float]:
    return {key: limit for key in keys if (limit := getattr(bounds, key)) is not None}
