"""Further tables of a report: perception, comfort, compute, paired differences, seeds needed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from vpf_sim.evaluation.analysis.summary import WIDTHS
from vpf_sim.reporting.cells import NONE, Order, Row, at, formatted, interval_of, interval_text, shown
from vpf_sim.reporting.stored_run import Record

Labels = dict[str, tuple[str, int, bool]]  # key: label, digits, in percent
PERCEPTION: Labels = {
    "foe_median_error_px.distance": ("focus of expansion, median error, px", 2, False),
    "foe_share": ("frames with one, %", 0, True),
    "edge_error_10m_m.median": ("road edges 10 m ahead, median error, m", 3, False),
    "edge_error_10m_m.p95": ("road edges, p95, m", 3, False),
    "flow_median_error_px": ("flow, median error, px", 2, False),
    "ttc_median_error": ("time to contact, median error, %", 0, True),
}
OBJECTS: Labels = {
    "objects.first_confirmed_m": ("objects first confirmed at, m", 1, False),
    "objects.recall": ("recall at the due distance, %", 0, True),
    "objects.precision": ("precision, %", 1, True),
    "objects.wrong_per_minute": ("false positives a minute", 2, False),
}
STAGES = {  # column -> stages of timing.jsonl that it adds up
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
COMPARED = {
    "success_rate": ("success", 0, True),
    "path_mse_m2": ("path MSE, m²", 3, False),
    "accuracy.shadow.throttle.range": ("throttle, points", 1, True),
    "accuracy.shadow.steering.range": ("steering, points", 1, True),
    "driving_score_2_1": ("driving score", 2, False),
}


@dataclass(frozen=True, slots=True)
class Value:
    """A cell: text, small text beside it, and the exact number."""

    text: str
    beside: str = ""
    value: float | None = None


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells; the first `names` columns are row names."""

    header: tuple[str, ...]
    rows: tuple[tuple[Value, ...], ...]
    names: int


def perception(rows: Sequence[Row], order: Order, labels: Labels) -> Table | None:
    """Perception metrics of drivers that expose their plan, one row per cell."""
    shown_plan = [row for row in sorted(rows, key=order.place) if _perceived(row, "foe_median_error_px")]
    scored_rows = [row for row in shown_plan if any(_perceived(row, key) is not None for key in labels)]
    keys = [key for key in labels if any(_perceived(row, key) is not None for row in scored_rows)]
    lines = tuple(
        (*names(row), *(score(row, f"perception.{key}", *labels[key][1:]) for key in keys)) for row in scored_rows
    )
    header = ("scenario", "weather", "driver", *(labels[key][0] for key in keys))
    return Table(header, lines, 3) if lines else None


def _perceived(row: Row, key: str) -> Any:
    return at(scored(row), f"perception.{key}")


def score(row: Row, key: str, digits: int, percent: bool) -> Value:
    """The mean of the successful episodes with its interval, or else that of the others in brackets."""
    value = at(scored(row), key)
    text = formatted(value, digits, percent)
    if value is None or row["successes"]:
        return Value(text, interval_text(interval_of(row, key), digits, percent), value)
    return Value(f"({text})", value=value)


def seeds_needed(rows: Sequence[Row], order: Order) -> Table | None:
    """Number of seeds for intervals of WIDTHS, one row per cell."""
    found = [row for row in sorted(rows, key=order.place) if row.get("seeds_needed")]
    lines = tuple((*names(row), Value(str(row["episodes"])), *_needed(row)) for row in found)
    success = f"for success within {100.0 * WIDTHS['success_rate']:g} points"
    path_mse = f"for path MSE within {WIDTHS['path_mse_m2']:g} m² (successful seeds)"
    header = ("scenario", "weather", "driver", "seeds so far", success, path_mse)
    return Table(header, lines, 3) if lines else None


def _needed(row: Row) -> Iterator[Value]:
    for key in ("success_rate", "path_mse_m2"):
        count = row["seeds_needed"].get(key)
        yield Value(NONE if count is None else str(count), value=count)


def comfort(records: Sequence[Record], order: Order) -> Table | None:
    """The share of each driver's successful episodes inside each of nuPlan's bounds."""
    lines = []
    for driver in order.drivers:
        found = [r["comfort"] for r in records if r["driver"] == driver and r["status"] == "success" and r["comfort"]]
        if not found:
            continue
        shares = [_inside([at(one, f"signals.{key}.within") for one in found]) for key in COMFORT]
        lines.append((Value(driver), *shares, _inside([one.get("comfortable") for one in found])))
    header = ("driver", *(f"{label} {bound}" for label, bound in COMFORT.values()), "all")
    return Table(header, tuple(lines), 1) if lines else None


def compute(timing: Mapping[str, dict[str, Any]], records: Sequence[Record], order: Order) -> Table | None:
    """Wall times by driver and weather."""
    lines = [
        (Value(driver), Value(shown(weather)), *_rates(times), *_stages(times))
        for driver in order.drivers
        for weather in order.weathers
        if (times := _timed(timing, records, driver, weather))
    ]
    staged = [f"{name}, ms" for name in STAGES] if any("stages_ms" in time for time in timing.values()) else []
    columns = ("steps a second", "times real time", "s an episode", "retries", *staged)
    lines = [line[: 2 + len(columns)] for line in lines]
    return Table(("driver", "weather", *columns), tuple(lines), 2) if lines else None


def _timed(
    timing: Mapping[str, dict[str, Any]], records: Sequence[Record], driver: str, weather: str
) -> list[dict[str, Any]]:
    ids = [record["id"] for record in records if (record["driver"], record["weather"]) == (driver, weather)]
    there = [timing[key] for key in ids if key in timing]
    return [time for time in there if time.get("steps_per_s") and time.get("wall_s")]


def _rates(times: Sequence[dict[str, Any]]) -> tuple[Value, ...]:
    rate = median(time["steps_per_s"] for time in times)
    return (
        Value(formatted(rate, 0), value=rate),
        Value(formatted(rate / REAL_TIME_HZ, 2)),
        Value(formatted(median(time["wall_s"] for time in times), 1)),
        Value(str(sum(time.get("retries", 0) for time in times))),
    )


def _stages(times: Sequence[dict[str, Any]]) -> Iterator[Value]:
    """Median time per step of each group of stages."""
    for parts in STAGES.values():
        found = [[time.get("stages_ms", {}).get(part) for part in parts] for time in times]
        sums = [sum(value for value in values if value is not None) for values in found if any(values)]
        yield Value(formatted(median(sums), 2) if sums else NONE)


def comparisons(found: Sequence[dict[str, Any]], of: str, order: Order) -> Table | None:
    """Paired differences of weathers or of drivers."""
    lines = []
    for one in sorted(found, key=order.place):
        if one["of"] == of:
            who = Value(f"{shown(one[of])} − {shown(one['minus'])}")
            where = (Value(shown(one["scenario"])), Value(shown(one["driver" if of == "weather" else "weather"])))
            lines.append((who, *where, *(_difference(one, key) for key in COMPARED)))
    header = (
        "what",
        "scenario",
        "driver" if of == "weather" else "weather",
        *(label for label, *_ in COMPARED.values()),
    )
    return Table(header, tuple(lines), 3) if lines else None


def _difference(one: dict[str, Any], key: str) -> Value:
    """The cell of a difference; `compare` uses dotted keys."""
    _, digits, percent = COMPARED[key]
    found = one.get(key)
    if not found:
        return Value(NONE)
    value = float(found["difference"])
    digits = _digits(value, digits, percent)
    sign = "+" if float(f"{100.0 * value if percent else value:.{digits}f}") > 0.0 else ""
    ends = found.get("interval")
    beside = [interval_text((ends[0], ends[1]), digits, percent)] if ends else []
    beside.append(f"p {_probability(found['p'])}, n {found['pairs']}")
    return Value(sign + formatted(value, digits, percent), "\n".join(beside), value)


def _digits(value: float, digits: int, percent: bool) -> int:
    """The number of decimals; more for a small difference that would be rounded to 0."""
    size = 100.0 * abs(value) if percent else abs(value)
    return next((more for more in range(digits, MOST_DIGITS) if round(size, more) > 0.0 or size == 0.0), digits)


def _probability(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}" if p < 0.1 else f"{p:.2f}"


def _inside(within: Sequence[bool | None]) -> Value:
    known = [value for value in within if value is not None]
    if not known:
        return Value(NONE)
    return Value(formatted(sum(known) / len(known), 0, True) + " %", f"{sum(known)} of {len(known)}")


def names(row: Row) -> tuple[Value, Value, Value]:
    """Scenario, weather and driver as the first columns."""
    return Value(shown(row["scenario"])), Value(shown(row["weather"])), Value(row["driver"])


def scored(row: Row) -> Row:
    """The scores of a row: of the successful episodes, or else of the others."""
    found: Row = row if row["successes"] else row.get("unsuccessful") or {}
    return found
