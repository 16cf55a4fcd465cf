"""Further tables of a report: accuracy, perception, comfort, compute, paired differences, seeds needed."""

from collections.abc import Iterator, Mapping, Sequence
from statistics import median

from vpf_sim.evaluation.analysis.comparisons import BASE_DRIVER
from vpf_sim.evaluation.analysis.rows import Comparison, Row
from vpf_sim.evaluation.analysis.statistics import Difference
from vpf_sim.evaluation.analysis.summary import WIDTHS
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.records import Record, Timing
from vpf_sim.evaluation.metrics.registry import BY_PART, COMFORTABLE, FOE, PASSING, PATH_MSE, SUCCESS, columns
from vpf_sim.reporting.kit.page import NONE, Line, Table, Value, formatted, interval_text
from vpf_sim.reporting.main_table import Order, ends_of, shown, text_of

PERCEPTION, OBJECTS, COMPARED = (columns(table) for table in ("perception", "objects", "pairs"))
STAGES = {  # column -> stages of timing.jsonl that it adds up, with those of older recordings
    "camera": ("render",),
    "flow": ("grey", "flow", "keyframe"),
    "FOE, pitch": ("derotation", "focus_of_expansion", "camera_pitch", "mount_pitch"),
    "road edges": ("road",),
    "obstacles": (
        *("contrast", "moving_prediction", "planar_parallax", "triangulation", "moving_obstacles", "track_refinement"),
        *("static_obstacles", "all_obstacles", "sensing_range", "point_features"),
        "prediction",
    ),
    "plan and control": ("plan", "control"),
    "physics": ("physics", "ending", "observation", "info"),
}
COMFORT = {  # nuPlan's signals and bounds
    "longitudinal_acceleration_mps2": ("longitudinal acceleration", "−4.05 to 2.40 m/s²"),
    "lateral_acceleration_mps2": ("lateral acceleration", "±4.89 m/s²"),
    "jerk_mps3": ("jerk", "±8.37 m/s³"),
    "longitudinal_jerk_mps3": ("longitudinal jerk", "±4.13 m/s³"),
    "yaw_rate_radps": ("yaw rate", "±0.95 rad/s"),
    "yaw_acceleration_radps2": ("yaw acceleration", "±1.93 rad/s²"),
}
REAL_TIME_HZ = 60.0
MOST_DIGITS = 7  # of a difference
SIGNALS = ("throttle", "steering")
WHERE = ("scenario", "weather", "driver")


def perception(rows: Sequence[Row], order: Order, metrics: Sequence[Metric]) -> Table | None:
    """Perception metrics of drivers that expose their plan, one row per cell."""
    perceived = [row for row in order.sorted(rows) if _has_foe(row)]
    scored = [row for row in perceived if any(row[metric] is not None for metric in metrics)]
    found = [metric for metric in metrics if any(row[metric] is not None for row in scored)]
    lines: tuple[Line, ...] = tuple((*names(row), *(score(row, metric) for metric in found)) for row in scored)
    header = ("scenario", "weather", "driver", *(metric.heading for metric in found))
    return Table(header, lines, 3) if lines else None


def _has_foe(row: Row) -> bool:
    return row[FOE] is not None


def score(row: Row, metric: Metric) -> Value:
    """The value of a metric with its interval, in brackets where it is of drives that did not arrive."""
    value = row[metric]
    text = text_of(metric, value)
    if value is not None and row.is_of_lost(metric):
        return Value(f"({text})", value=value)
    return Value(text, ends_of(metric, row), value)


def seeds_needed(rows: Sequence[Row], order: Order) -> Table | None:
    """Number of seeds for intervals of WIDTHS, one row per cell."""
    found = [row for row in order.sorted(rows) if row.seeds_needed]
    lines: tuple[Line, ...] = tuple((*names(row), Value(str(row.episodes)), *_needed(row)) for row in found)
    success = f"for success within {100.0 * WIDTHS[SUCCESS.row_key]:g} points"
    path_mse = f"for path MSE within {WIDTHS[PATH_MSE.row_key]:g} m² (successful seeds)"
    header = ("scenario", "weather", "driver", "seeds so far", success, path_mse)
    return Table(header, lines, 3) if lines else None


def _needed(row: Row) -> Iterator[Value]:
    for metric in (SUCCESS, PATH_MSE):
        count = row.seeds_needed.get(metric.row_key)
        yield Value(NONE if count is None else str(count), value=count)


def comfort(records: Sequence[Record], order: Order) -> Table | None:
    """The share of each driver's successful episodes inside each of nuPlan's bounds."""
    lines: list[Line] = []
    for driver in order.drivers:
        found = [one for one in records if one.driver == driver and one.succeeded and one[COMFORTABLE] is not None]
        if not found:
            continue
        shares = [_inside([one.scores.get(f"comfort.signals.{key}.within") for one in found]) for key in COMFORT]
        lines.append((driver, *shares, _inside([one[COMFORTABLE] for one in found])))
    header = ("driver", *(f"{label} {bound}" for label, bound in COMFORT.values()), "all")
    return Table(header, tuple(lines), 1) if lines else None


def compute(timing: Mapping[str, Timing], records: Sequence[Record], order: Order) -> Table | None:
    """Wall times by driver and weather."""
    lines: list[Line] = [
        (driver, shown(weather), *_rates(times), *_stages(times))
        for driver in order.drivers
        for weather in order.weathers
        if (times := _timed(timing, records, driver, weather))
    ]
    staged = [f"{name}, ms" for name in STAGES] if any(time.stages_ms for time in timing.values()) else []
    columns = ("steps a second", "times real time", "s an episode", "retries", *staged)
    lines = [line[: 2 + len(columns)] for line in lines]
    return Table(("driver", "weather", *columns), tuple(lines), 2) if lines else None


def _timed(timing: Mapping[str, Timing], records: Sequence[Record], driver: str, weather: str) -> list[Timing]:
    ids = [record.id for record in records if (record.driver, record.weather) == (driver, weather)]
    there = [timing[key] for key in ids if key in timing]
    return [time for time in there if time.steps_per_s and time.wall_s]


def _rates(times: Sequence[Timing]) -> tuple[Value, ...]:
    rate = median(time.steps_per_s or 0.0 for time in times)
    return (
        Value(formatted(rate, 0), value=rate),
        Value(formatted(rate / REAL_TIME_HZ, 2)),
        Value(formatted(median(time.wall_s or 0.0 for time in times), 1)),
        Value(str(sum(time.retries for time in times))),
    )


def _stages(times: Sequence[Timing]) -> Iterator[Value]:
    """Median time per step of each group of stages."""
    for parts in STAGES.values():
        found = [[time.stages_ms.get(part) for part in parts] for time in times]
        sums = [sum(value for value in values if value is not None) for values in found if any(values)]
        yield Value(formatted(median(sums), 2) if sums else NONE)


def comparisons(found: Sequence[Comparison], of: str, order: Order) -> Table | None:
    """Paired differences of weathers or of drivers."""
    lines: list[Line] = []
    kept = "driver" if of == "weather" else "weather"
    for one in sorted(found, key=order.place):
        if one.of == of:
            who = f"{shown(getattr(one.cell, of))} − {shown(one.minus)}"
            where = (shown(one.cell.scenario), shown(getattr(one.cell, kept)))
            lines.append((who, *where, *(_difference(one.differences.get(key.key), key) for key in COMPARED)))
    return Table(("what", "scenario", kept, *(one.heading for one in COMPARED)), tuple(lines), 3) if lines else None


def _difference(found: Difference | None, metric: Metric) -> Value:
    """The cell of a difference."""
    if found is None:
        return Value(NONE)
    value, percent = found.difference, metric.percent
    digits = _digits(value, metric.digits, percent)
    sign = "+" if float(f"{100.0 * value if percent else value:.{digits}f}") > 0.0 else ""
    beside = [interval_text(found.interval, digits, percent)] if found.interval else []
    beside.append(f"p {_probability(found.p)}, n {found.pairs}")
    return Value(sign + formatted(value, digits, percent), "\n".join(beside), value)


def _digits(value: float, digits: int, percent: bool) -> int:
    """The number of decimals; more for a small difference that would be rounded to 0."""
    size = 100.0 * abs(value) if percent else abs(value)
    return next((more for more in range(digits, MOST_DIGITS) if round(size, more) > 0.0 or size == 0.0), digits)


def _probability(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}" if p < 0.1 else f"{p:.2f}"


def _inside(within: Sequence[float | None]) -> Value:
    known = [value for value in within if value is not None]
    if not known:
        return Value(NONE)
    return Value(formatted(sum(known) / len(known), 0, True) + " %", f"{sum(known):.0f} of {len(known)}")


def names(row: Row) -> tuple[str, str, str]:
    """Scenario, weather and driver as the first columns."""
    return shown(row.scenario), shown(row.weather), row.driver


def by_definition(rows: Sequence[Row], order: Order, signal: str) -> Table | None:
    """A signal's accuracy in percent, one row per cell."""
    metrics = columns(signal)
    others = [row for row in order.sorted(rows) if row.driver != BASE_DRIVER]
    shown = [row for row in others if any(row[metric] is not None for metric in metrics)]
    lines: tuple[Line, ...] = tuple(
        (*names(row), *_paper(row, signal), *(score(row, metric) for metric in metrics)) for row in shown
    )
    paper = ["the paper, undefined"] if any(_paper(row, signal) for row in shown) else []
    return Table((*WHERE, *paper, *(metric.title for metric in metrics)), lines, 3) if lines else None


def by_part(rows: Sequence[Row], order: Order) -> Table | None:
    """Path MSE and accuracies clear of obstacles and passing one, one row per cell with obstacles."""
    shown = [row for row in order.sorted(rows) if row[PASSING] is not None]
    lines: tuple[Line, ...] = tuple((*names(row), *(score(row, metric) for metric in BY_PART)) for row in shown)
    return Table((*WHERE, *(metric.title for metric in BY_PART)), lines, 3) if lines else None


def _paper(row: Row, signal: str) -> tuple[Value, ...]:
    """The paper's value; empty in other runs."""
    if not row.paper:
        return ()
    value = row.paper[signal]
    return (Value(formatted(value, 2, True), value=value),)
