"""The tables beside the main one: what was perceived, how comfortable it was, what it cost, what differs by pairs."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from vpf_sim.evaluation.job import Job
from vpf_sim.report.cells import NONE, Order, Row, at, interval_of, interval_words, shown, worded
from vpf_sim.report.stored_run import Record

PERCEPTION = {  # key, label, digits, in percent
    "foe_median_error_px.distance": ("focus of expansion, median error, px", 2, False),
    "foe_share": ("frames with one, %", 0, True),
    "edge_error_10m_m.median": ("road edges 10 m ahead, median error, m", 3, False),
    "edge_error_10m_m.p95": ("road edges, p95, m", 3, False),
    "flow_median_error_px": ("flow, median error, px", 2, False),
    "ttc_median_error": ("time to contact, median error, %", 0, True),
    "objects.first_confirmed_m": ("objects first confirmed at, m", 1, False),
    "objects.recall": ("objects in time, %", 0, True),
    "objects.precision": ("reports that are right, %", 1, True),
    "objects.wrong_per_minute": ("wrong objects a minute", 2, False),
}
STAGES = {  # of a step, as timing.jsonl names them: what each column adds up
    "camera": ("render",),
    "flow": ("grey", "flow"),
    "FOE, TTC, obstacles": ("foe", "ttc", "obstacle_map", "landmarks"),
    "road edges": ("road",),
    "plan and control": ("plan", "control"),
    "physics": ("physics",),
}
COMFORT = {  # nuPlan's names and bounds
    "longitudinal_acceleration_mps2": ("longitudinal acceleration", "−4.05 to 2.40 m/s²"),
    "lateral_acceleration_mps2": ("lateral acceleration", "±4.89 m/s²"),
    "jerk_mps3": ("jerk", "±8.37 m/s³"),
    "longitudinal_jerk_mps3": ("longitudinal jerk", "±4.13 m/s³"),
    "yaw_rate_radps": ("yaw rate", "±0.95 rad/s"),
    "yaw_acceleration_radps2": ("yaw acceleration", "±1.93 rad/s²"),
}
REAL_TIME_HZ = 60.0
COMPARED = {
    "success_rate": ("success", 0, True),
    "path_mse_m2": ("path MSE, m²", 3, False),
    "accuracy.shadow.throttle.range": ("throttle, points", 1, True),
    "accuracy.shadow.steering.range": ("steering, points", 1, True),
    "driving_score_2_1": ("driving score", 2, False),
}


@dataclass(frozen=True, slots=True)
class Value:
    """A cell: words, what is said of them beside, and the exact number."""

    words: str
    beside: str = ""
    value: float | None = None


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of words, the first few columns names."""

    header: tuple[str, ...]
    rows: tuple[tuple[Value, ...], ...]
    names: int  # how many columns are names


def perception(rows: Sequence[Row], order: Order) -> Table | None:
    """What the drivers that show their plan saw, against the truth; a line a cell, successful episodes."""
    seen = [row for row in sorted(rows, key=order.place) if at(_scored(row), "perception.foe_median_error_px")]
    told = [key for key in PERCEPTION if any(at(_scored(row), f"perception.{key}") is not None for row in seen)]
    lines = tuple((*_names(row), *(_perceived(row, key) for key in told)) for row in seen)
    header = ("scenario", "weather", "driver", *(PERCEPTION[key][0] for key in told))
    return Table(header, lines, 3) if lines else None


def _perceived(row: Row, key: str) -> Value:
    """Of a driver that never arrived the mean over all its episodes, in brackets."""
    _, digits, percent = PERCEPTION[key]
    value = at(_scored(row), f"perception.{key}")
    words = worded(value, digits, percent)
    if value is None or row["successes"]:
        return Value(words, interval_words(interval_of(row, f"perception.{key}"), digits, percent), value)
    return Value(f"({words})", value=value)


def comfort(records: Sequence[Record], order: Order) -> Table | None:
    """Of each driver's successful episodes, the share inside each of nuPlan's bounds."""
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
    """What a clock measured, by driver and weather."""
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
    return [timing[key] for key in ids if timing.get(key, {}).get("steps_per_s")]


def _rates(times: Sequence[dict[str, Any]]) -> tuple[Value, ...]:
    rate = median(time["steps_per_s"] for time in times)
    return (
        Value(worded(rate, 0), value=rate),
        Value(worded(rate / REAL_TIME_HZ, 2)),
        Value(worded(median(time["wall_s"] for time in times), 1)),
        Value(str(sum(time.get("retries", 0) for time in times))),
    )


def _stages(times: Sequence[dict[str, Any]]) -> Iterator[Value]:
    """Medians over the episodes of the medians over their steps."""
    for parts in STAGES.values():
        found = [[time.get("stages_ms", {}).get(part) for part in parts] for time in times]
        sums = [sum(value for value in values if value is not None) for values in found if any(values)]
        yield Value(worded(median(sums), 2) if sums else NONE)


def comparisons(found: Sequence[dict[str, Any]], of: str, order: Order) -> Table | None:
    """Differences on the same seeds, of weathers or of drivers."""
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
    """`compare` names its scores by dotted keys, flat."""
    _, digits, percent = COMPARED[key]
    told = one.get(key)
    if not told:
        return Value(NONE)
    value = float(told["difference"])
    sign = "+" if float(f"{100.0 * value if percent else value:.{digits}f}") > 0.0 else ""
    ends = told.get("interval")
    beside = [interval_words((ends[0], ends[1]), digits, percent)] if ends else []
    beside.append(f"p {_probability(told['p'])}, n {told['pairs']}")
    return Value(sign + worded(value, digits, percent), "\n".join(beside), value)


def _probability(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}" if p < 0.1 else f"{p:.2f}"


def _inside(within: Sequence[bool | None]) -> Value:
    there = [value for value in within if value is not None]
    if not there:
        return Value(NONE)
    return Value(worded(sum(there) / len(there), 0, True) + " %", f"{sum(there)} of {len(there)}")


def _names(row: Row) -> tuple[Value, Value, Value]:
    return Value(shown(row["scenario"])), Value(shown(row["weather"])), Value(row["driver"])


def _scored(row: Row) -> Row:
    scored: Row = row if row["successes"] else row.get("unsuccessful") or {}
    return scored


@dataclass(frozen=True, slots=True)
class MapRow:
    """Of the success map: how each seed ended."""

    scenario: str
    weather: str
    driver: str
    style: str
    cells: tuple[tuple[int, str, str], ...]  # seed, status, title


SIGNS = {
    "success": "✓",
    "collision": "✕",
    "off_road": "⇲",
    "timeout": "◷",
    "stuck": "■",
    "invalid_frame": "▦",
    "error": "!",
    "missing": "·",
}


def signs(jobs: Sequence[Job], records: Mapping[str, Record]) -> list[tuple[str, str, int]]:
    """(status, sign, how often) of what is on the success map."""
    counts = Counter(records[job.id]["status"] if job.id in records else "missing" for job in jobs)
    return [(status, sign, counts[status]) for status, sign in SIGNS.items() if status in counts]


def success_map(jobs: Sequence[Job], records: Mapping[str, Record], order: Order) -> Iterator[MapRow]:
    """A row a cell and driver, a mark a planned seed."""
    cells: dict[tuple[str, str, str], list[tuple[int, str, str]]] = {}
    for job in jobs:
        record = records.get(job.id)
        status = record["status"] if record else "missing"
        hit = f" with a {record['collided_with']}" if record and record.get("collided_with") else ""
        came = f", {100.0 * record['route_completion']:.0f} % of the way" if record else ""
        title = f"{job.id}: {status.replace('_', ' ')}{hit}{came}"
        cells.setdefault((job.scenario, job.weather, job.driver), []).append((job.seed, status, title))
    for scenario, weather in order.cells():
        for driver in order.drivers:
            found = cells.get((scenario, weather, driver))
            if found:
                yield MapRow(shown(scenario), shown(weather), driver, order.style(driver), tuple(sorted(found)))
