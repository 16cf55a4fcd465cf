"""The tables of a replay as text, for the terminal and the page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vpf_sim.replay.scores import PARTS
from vpf_sim.reporting.kit.page import formatted

PART_NAMES = {PARTS[0]: "no obstacles", PARTS[1]: "with obstacles", "not divided": "not divided"}
NOTHING = "no recording"
ORIGIN_SIGNALS = (
    "camera",
    "times_s",
    "poses",
    "speed_mps",
    "yaw_rate_radps",
    "steering_rad",
    "throttle",
    "obstacle",
    "foe_px",
)


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of text; the first `words` columns name the row, the others are numbers."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int = 1
    notes: tuple[str, ...] = ()
    empty: int = 0  # rows at the end without a recording


def tables(
    records: Sequence[dict[str, Any]], timing: Mapping[str, dict[str, Any]], summary: dict[str, Any]
) -> list[Table]:
    """All tables with rows; the paper's comes last."""
    found = [
        warnings(records),
        drives(records),
        origins(records),
        lanes(records),
        checks(records),
        perception(records),
        compute(records, timing),
        mountings(records),
        real_images(summary["rows"], summary["differences"]),
    ]
    return [table for table in found if table.rows]


def real_images(rows: Sequence[dict[str, Any]], differences: Sequence[str]) -> Table:
    """Commands beside the human's and the paper's cells; those without a recording come last."""
    names = ("weather", "part", "signals", "drives")
    scores = ("range", "span", "tol.", "mae", "idle")
    of_both = [f"{signal} {score}" for signal in ("a", "δ") for score in scores]
    notes = (
        "a is throttle, δ steering; range, span and tol. (tolerance) are accuracies in %, mae the mean |difference|; "
        "idle is the range accuracy of zero commands, which shows the share of the road; unseen is the "
        "share of scored frames without an image or with the last command held. Assumed signals are not scored.",
        *differences,
    )
    header = (*names, "frames", "unseen %", *of_both, "paper a", "paper δ")
    ordered = sorted(rows, key=lambda row: not row["frames"])
    empty = sum(not row["frames"] for row in rows)
    return Table(
        "Throttle and steering beside the human's", header, tuple(map(_score, ordered)), len(names), notes, empty
    )


def _score(row: dict[str, Any]) -> tuple[str, ...]:
    weather = row["weather"] + (f" + {row['added']}" if row["added"] else "")
    kinds = row["signals"]
    signals = f"a {kinds['throttle']}, δ {kinds['steering']}" if row["frames"] else NOTHING
    cells = [weather, PART_NAMES[row["part"]], signals, ", ".join(row["drives"]), str(row["frames"])]
    cells.append(formatted(row["unseen"] / row["frames"] if row["frames"] else None, 1, True))
    for name in ("throttle", "steering"):
        scores, idle = row["accuracy"][name] or {}, row["idle"][name] or {}
        cells += [formatted(scores.get(key), 1, True) for key in ("range", "span", "tolerance")]
        cells += [formatted(scores.get("mae"), 3), formatted(idle.get("range"), 1, True)]
    paper = row["paper"] or {}
    return (*cells, *(formatted(paper.get(name), 1, True) for name in ("throttle", "steering")))


def drives(records: Sequence[dict[str, Any]]) -> Table:
    """The drives and how they were driven."""
    header = (
        "drive",
        "layout",
        "weather",
        "camera",
        "obstacles by",
        "frames",
        "gaps",
        "segments",
        "restarts",
        "road found %",
    )
    notes = [
        f"{record['name']}: {record['protocol']}; goal: {record['goal']}" for record in records if record["driven"]
    ]
    notes += [f"{record['name']}: {note}" for record in records for note in record["notes"]]
    notes += [f"{record['name']}: {_error(record['error'])}" for record in records if record["error"]]
    notes += [record["no_images"] for record in records if record["no_images"]]
    return Table("The drives", header, tuple(_drive(record) for record in records), 5, tuple(notes))


def _error(error: dict[str, Any]) -> str:
    """Why a drive ended early."""
    return f"the driver failed at frame {error['frame']}, at {error['place']}: {error['what']}; not scored"


def _drive(record: dict[str, Any]) -> tuple[str, ...]:
    camera = record["camera"]
    return (
        record["name"],
        record["layout"],
        record["weather"] or "unknown",
        f"{camera['width_px']} x {camera['height_px']}, {record['rate_hz']:.3g} Hz",
        record["obstacles_by"] or "none",
        str(record["frames"]),
        str(record["gaps"]),
        str(record["segments"]),
        str(record["restarts"]),
        formatted(record["perception"]["road_found_share"], 1, True),
    )


def origins(records: Sequence[dict[str, Any]]) -> Table:
    """The origin of each signal."""
    rows = [
        (record["name"], name, record["origins"][name]["kind"], record["origins"][name]["how"])
        for record in records
        for name in ORIGIN_SIGNALS
    ]
    return Table("Origin of the signals", ("drive", "signal", "origin", "how"), tuple(rows), 4)


def mountings(records: Sequence[dict[str, Any]]) -> Table:
    """Estimated camera mountings."""
    header = ("drive", "angle", "used", "deg", "from", "to", "straight s")
    keys = ("deg", "from_deg", "to_deg", "straight_s")
    rows = [
        (record["name"], name, "yes" if one["used"] else "no", *(formatted(one[key], 1) for key in keys))
        for record in records
        for name, one in (record.get("mounting") or {}).items()
    ]
    note = "from and to: the interval at 95 %. An angle that is not used is assumed to be 0."
    return Table("Estimated camera mounting", header, tuple(rows), 3, (note,))


def warnings(records: Sequence[dict[str, Any]]) -> Table:
    """Warnings, one line each."""
    rows = [(record["name"], what, why) for record in records for what, why in record.get("warnings", [])]
    return Table("Warnings", ("drive", "what", "why"), tuple(rows), 3)


def lanes(records: Sequence[dict[str, Any]]) -> Table:
    """Steering with and without a lane."""
    header = ("drive", "lane", "frames", "δ range", "δ span", "δ mae", "idle mae")
    rows = [
        _lane(record["name"], words, record["accuracy"]["lane"][key])
        for record in records
        if record["accuracy"] and record["perception"]["road_found_share"] is not None
        for key, words in (("found", "found"), ("not_found", "not found"))
    ]
    note = "Without a lane the model car holds course and speed; these frames are not scored."
    return Table("Steering with and without a lane", header, tuple(row for row in rows if row[2] != "0"), 2, (note,))


def _lane(name: str, words: str, part: dict[str, Any]) -> tuple[str, ...]:
    scores, idle = part["steering"] or {}, part["idle"] or {}
    shares = [formatted(scores.get(key), 1, True) for key in ("range", "span")]
    return (name, words, str(part["frames"]), *shares, *(formatted(one.get("mae"), 4) for one in (scores, idle)))


def checks(records: Sequence[dict[str, Any]]) -> Table:
    """Independent signals checked by physics."""
    checked = [(record["name"], record["signal_checks"]["yaw_rate"]) for record in records]
    rows = [(name, formatted(one["gain"], 3), formatted(one["correlation"], 3)) for name, one in checked if one]
    note = (
        "gain: slope of the yaw rate over v tan(δ) / 2.7 m; 1 for correct ratio, wheelbase and sign without slip, "
        "negative for a wrong sign, about 0.5 for an understeering car at 25 m/s."
    )
    return Table("Signals checked by physics", ("drive", "gain", "correlation"), tuple(rows), notes=(note,))


def perception(records: Sequence[dict[str, Any]]) -> Table:
    """Perception against ground truth."""
    foe = ("FOE x px", "FOE y px", "own x px", "own y px", "FOE found %", "spread x px", "spread y px")
    header = ("drive", *foe, "yaw rate rad/s", "speed scale", "TTC error %", "within 25 %", "false alarms %")
    notes = (
        "FOE: median error of the focus of expansion, recorded rotation removed; own: without recorded rotation; "
        "spread: interquartile range; yaw rate: median error by the flow; speed scale: by the road's flow / recorded; "
        "TTC: to the lead vehicle where the gap closes faster than 0.5 m/s; false alarms: below 4 s while both stand.",
    )
    driven = tuple(_perception_row(record) for record in records if record["driven"])
    return Table("Perception against ground truth", header, driven, notes=notes)


def _perception_row(record: dict[str, Any]) -> tuple[str, ...]:
    scores = record["perception"]
    errors = [record[key] or {} for key in ("foe_median_error_px", "foe_median_error_own_derotation_px")]
    spread, ttc = scores["foe"]["interquartile_range_px"] or {}, scores["ttc"] or {}
    return (
        record["name"],
        *(formatted(error.get(axis), 1) for error in errors for axis in ("x", "y")),
        formatted(scores["foe"]["share"], 1, True),
        *(formatted(spread.get(axis), 1) for axis in ("x", "y")),
        formatted(scores["yaw_rate_median_error_radps"], 4),
        formatted((scores["speed_scale"] or {}).get("median"), 2),
        *(formatted(ttc.get(key), 1, True) for key in ("median_error", "within_25_percent", "false_alarms")),
    )


def compute(records: Sequence[dict[str, Any]], timing: Mapping[str, dict[str, Any]]) -> Table:
    """Computing time on one core."""
    header = ("drive", "driver", "driver 95 %", "reading", "period", "times real time")
    keys = ("driver_ms", "driver_p95_ms", "reading_ms", "period_ms", "real_time")
    there = [record["name"] for record in records if record["driven"] and record["name"] in timing]
    rows = [(name, *(formatted(timing[name][key], 1) for key in keys)) for name in there]
    return Table("Time on one core, ms a frame", header, tuple(rows), notes=("medians of CPU time",))
