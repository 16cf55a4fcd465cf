"""The registry of metrics: what an episode's record holds, and how tables, pages, rules and data frames show it.

A new metric is one function of a driven episode, and one `Metric` in METRICS.
"""

import numpy as np

from vpf_sim.evaluation.metrics import collision, comfort, perception, tracking
from vpf_sim.evaluation.metrics.metric import Driven, Measure, Metric
from vpf_sim.evaluation.metrics.tracking import protocol
from vpf_sim.evaluation.steps import StepTable


def _parts(driven: Driven) -> dict[str, float | None]:
    """Path MSE of the route's parts without and with obstacles beside the car."""
    passing = driven.table.passing > 0.0
    parts = {"clear_of_obstacles": ~passing, "passing": passing}
    positions_m = driven.table.positions_m
    return {part: tracking.path_mse(positions_m[rows], driven.reference) for part, rows in parts.items()}


def _accuracy(driven: Driven) -> dict[str, object]:
    """Accuracy by both protocols, over the n states with a command."""
    table = driven.table
    states = slice(0, len(table))
    commands, shadow, paired = (
        {name: getattr(table, f"{whose}{name}")[states] for name in ("throttle", "steering")}
        for whose in ("", "pid_", "paired_")
    )
    passing = table.passing[states] > 0.0
    return {"shadow": protocol(commands, shadow, passing), "paired": protocol(commands, paired, passing)}


def _perception(driven: Driven) -> dict[str, object]:
    table = driven.table
    estimated = np.concatenate([table.seen_left_m, table.seen_right_m])
    true = np.concatenate([table.true_left_m, table.true_right_m])
    return {
        **perception.foe(table.foe_x_px, table.foe_y_px, table.true_foe_x_px, table.true_foe_y_px),
        **perception.edges(estimated, true),
        **perception.points(table.flow_error_px, table.ttc_error),
        "objects": perception.objects(table),
    }


def uncertainty(table: StepTable) -> dict[str, float | None]:
    """Mean and largest uncertainty that the driver states, and its share of unsure states; None of a driver without."""
    stated = table.uncertainty[np.isfinite(table.uncertainty)]
    if not len(stated):
        return {"mean": None, "max": None, "unsure_share": None}
    return {"mean": stated.mean(), "max": stated.max(), "unsure_share": np.mean(stated > 1.0)}


def _off_lane(table: StepTable) -> float:
    return collision.off_lane_share(table.route_m, table.outside)


def _at_fault(driven: Driven) -> int:
    kind = collision_type(driven)
    return int(kind is not None and collision.is_at_fault(kind, driven.table))


def collision_type(driven: Driven) -> str | None:
    """The type of the collision that ended an episode; None without one."""
    return collision.collision_type(driven.table) if driven.hits else None


def _score_2_0(driven: Driven) -> float:
    return collision.driving_score_2_0(driven.completion, driven.hits, _off_lane(driven.table))


def _score_2_1(driven: Driven) -> float:
    return collision.driving_score_2_1(driven.completion, driven.hits, _off_lane(driven.table))


SUCCESS = Metric(
    "success_rate",
    over="nothing",
    title="reached the goal",
    unit="%",
    digits=0,
    rule="success_rate",
    tables=("two runs", "pairs", "chart"),
    perfect=1.0,
)
COLLISIONS = Metric(
    "collisions",
    lambda driven: len(driven.hits),
    "nothing",
    unmeasured=0,
    title="collisions",
    digits=0,
    better="less",
    rule="collisions",
    perfect=0.0,
)
AT_FAULT = Metric(
    "at_fault_collisions", _at_fault, "nothing", unmeasured=0, title="collisions at fault", digits=0, better="less"
)
COMPLETION = Metric(
    "route_completion",
    lambda driven: driven.completion,
    "driven",
    unmeasured=0.0,
    title="route completed",
    unit="%",
    digits=1,
    tables=("two runs",),
)
PATH_MSE = Metric(
    "path_mse_m2",
    lambda driven: tracking.path_mse(driven.table.positions_m, driven.reference),
    title="path MSE",
    unit="m²",
    digits=3,
    better="less",
    rule="path_mse_m2",
    paper="path_mse_m2",
    tables=("driving", "results", "two runs", "pairs", "chart"),
)
LANE_OFFSET = Metric(
    "max_lane_offset_m",
    lambda driven: np.max(np.abs(driven.table.lane_offset_m)),
    title="largest offset from the lane",
    unit="m",
    better="less",
)
THROTTLE = Metric(
    "accuracy.shadow.throttle.range",
    title="throttle accuracy",
    unit="%",
    digits=1,
    paper="throttle",
    tables=("driving", "two runs", "pairs", "chart"),
    perfect=1.0,
)
STEERING = Metric(
    "accuracy.shadow.steering.range",
    title="steering accuracy",
    unit="%",
    digits=1,
    paper="steering",
    tables=("driving", "two runs", "pairs", "chart"),
    perfect=1.0,
)
LEAST_CLEARANCE = Metric(
    "min_clearance_m",
    over="nothing",
    in_cell="least_clearance_m",
    title="least clearance",
    unit="m",
    tables=("driving", "results"),
)
DRIVING_SCORE_2_0 = Metric("driving_score_2_0", _score_2_0, "driven", unmeasured=0.0, title="driving score 2.0")
DRIVING_SCORE = Metric(
    "driving_score_2_1",
    _score_2_1,
    "driven",
    unmeasured=0.0,
    title="driving score",
    tables=("driving", "results", "two runs", "pairs", "chart"),
    perfect=1.0,
)
CLEARANCE = Metric(
    "min_clearance_m",
    lambda driven: collision.min_clearance_m(driven.table.clearance_m),
    title="least clearance",
    unit="m",
    rule="clearance_m",
    tables=("two runs", "chart"),
)
COMFORTABLE = Metric(
    "comfort.comfortable",
    over="nothing",
    in_cell="comfortable_share",
    title="comfortable",
    unit="%",
    digits=0,
    rule="comfortable_share",
    tables=("driving", "results", "two runs"),
    perfect=1.0,
)
CLEAR_PATH_MSE = Metric(
    "path_mse_parts_m2.clear_of_obstacles",
    title="path MSE, clear of obstacles",
    unit="m²",
    digits=3,
    better="less",
    rule="clear_path_mse_m2",
)
FOE = Metric(
    "perception.foe_median_error_px.distance",
    title="focus of expansion, median error",
    unit="px",
    better="less",
    of_perception=True,
    rule="foe_error_px",
    tables=("perception", "two runs"),
)
BY_PART = (
    *(
        Metric(f"path_mse_parts_m2.{part}", title=f"path MSE, m², {part.replace('_', ' ')}", digits=3, better="less")
        for part in ("clear_of_obstacles", "passing")
    ),
    *(
        Metric(
            f"accuracy.shadow.{part}.{signal}.range",
            title=f"{signal}, %, {part.replace('_', ' ')}",
            unit="%",
            digits=1,
        )
        for signal in ("throttle", "steering")
        for part in ("clear_of_obstacles", "passing")
    ),
)
PASSING = BY_PART[1]
BY_DEFINITION = tuple(
    Metric(
        f"accuracy.{protocol}.{signal}.{definition}",
        title=f"{protocol}, {definition}",
        unit="%",
        digits=1,
        tables=(signal,),
    )
    for signal in ("throttle", "steering")
    for protocol in ("shadow", "paired")
    for definition in ("range", "span", "tolerance")
)
METRICS = (
    SUCCESS,
    COLLISIONS,
    AT_FAULT,
    COMPLETION,
    PATH_MSE,
    LANE_OFFSET,
    THROTTLE,
    STEERING,
    LEAST_CLEARANCE,
    DRIVING_SCORE_2_0,
    DRIVING_SCORE,
    CLEARANCE,
    COMFORTABLE,
    CLEAR_PATH_MSE,
    Metric(
        "chattering.steering.direction_changes_per_s",
        title="steering reversals",
        unit="1/s",
        digits=1,
        better="less",
        rule="steering_reversals_per_s",
        tables=("results", "two runs"),
    ),
    Metric(
        "chattering.steering_rate_radps.p95",
        title="steering rate, p95",
        unit="rad/s",
        better="less",
        rule="steering_rate_radps",
        tables=("results",),
    ),
    FOE,
    Metric(
        "perception.foe_share",
        title="frames with one",
        unit="%",
        digits=0,
        of_perception=True,
        tables=("perception",),
    ),
    Metric(
        "perception.edge_error_10m_m.median",
        title="road edges 10 m ahead, median error",
        unit="m",
        digits=3,
        better="less",
        of_perception=True,
        rule="edge_error_m",
        tables=("perception", "two runs"),
    ),
    Metric(
        "perception.edge_error_10m_m.p95",
        title="road edges, p95",
        unit="m",
        digits=3,
        better="less",
        of_perception=True,
        tables=("perception",),
    ),
    Metric(
        "perception.flow_median_error_px",
        title="flow, median error",
        unit="px",
        better="less",
        of_perception=True,
        tables=("perception",),
    ),
    Metric(
        "perception.ttc_median_error",
        title="time to contact, median error",
        unit="%",
        digits=0,
        better="less",
        of_perception=True,
        tables=("perception",),
    ),
    Metric(
        "perception.objects.first_confirmed_m",
        title="objects first confirmed at",
        unit="m",
        digits=1,
        of_perception=True,
        tables=("objects",),
    ),
    Metric(
        "perception.objects.recall",
        title="recall at the due distance",
        unit="%",
        digits=0,
        of_perception=True,
        rule="recall",
        tables=("objects", "two runs"),
    ),
    Metric(
        "perception.objects.precision",
        title="precision",
        unit="%",
        digits=1,
        of_perception=True,
        rule="precision",
        tables=("objects", "two runs"),
    ),
    Metric(
        "perception.objects.wrong_per_minute",
        title="false positives a minute",
        better="less",
        of_perception=True,
        rule="false_positives_per_minute",
        tables=("objects",),
    ),
)
TABLES = (  # of scores
    Measure("path_mse_parts_m2", _parts),
    Measure("accuracy", _accuracy),
    Measure("comfort", lambda driven: comfort.comfort(driven.table), "nothing"),
    Measure("chattering", lambda driven: comfort.chattering(driven.table)),
    Measure("perception", _perception),
    Measure("uncertainty", lambda driven: uncertainty(driven.table), "nothing"),
)
MEASURES: tuple[Measure, ...] = (*(metric for metric in METRICS if metric.of), *TABLES)


def columns(table: str) -> tuple[Metric, ...]:
    """The metrics that are columns of a table."""
    return tuple(metric for metric in (*METRICS, *BY_DEFINITION) if table in metric.tables)


def with_rules() -> dict[str, Metric]:
    """The metrics that the gate has rules for, by the rules' name."""
    return {metric.rule: metric for metric in METRICS if metric.rule}
