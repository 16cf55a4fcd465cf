"""The tables of a replay, in words, for the terminal and for the page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vpf_sim.replay.scores import PARTS
from vpf_sim.report.cells import formatted

PART_NAMES = {PARTS[0]: "no obstacles", PARTS[1]: "with obstacles", "not divided": "not divided"}
NOTHING = "no recording"
TOLD = ("camera", "times_s", "poses", "speed_mps", "yaw_rate_radps", "steering_rad", "throttle", "obstacle", "foe_px")


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of words; the first `words` name the row, the others are numbers."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int = 1
    notes: tuple[str, ...] = ()


def tables(
    records: Sequence[dict[str, Any]], timing: Mapping[str, dict[str, Any]], summary: dict[str, Any]
) -> list[Table]:
    """All of them, those without a row left out."""
    found = [
        real_images(summary["rows"], summary["differences"]),
        drives(records),
        origins(records),
        lanes(records),
        checks(records),
        perception(records),
        compute(records, timing),
        mountings(records),
        doubts(records),
    ]
    return [table for table in found if table.rows]


def real_images(rows: Sequence[dict[str, Any]], differences: Sequence[str]) -> Table:
    """Commands beside the human's, and the paper's cells beside them."""
    names = ("weather", "part", "signals", "drives")
    scores = ("range", "span", "tol.", "mae", "idle")
    of_both = [f"{signal} {score}" for signal in ("a", "δ") for score in scores]
    notes = (
        "a is throttle, δ steering; range, span and tol. (tolerance) are accuracies in %, mae the mean |difference|; "
        "idle is the range accuracy of touching nothing: what of it is the road's and not the driver's; unseen is the "
        "share of scored frames without a picture or with the last command held. What is assumed is not scored.",
        *differences,
    )
    header = (*names, "frames", "unseen %", *of_both, "paper a", "paper δ")
    return Table("Throttle and steering beside the human's", header, tuple(map(_score, rows)), len(names), notes)


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
    """What each drive is, and how it was driven."""
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
    return f"the driver failed at frame {error['frame']}, at {error['place']}: {error['what']}; in no row of the scores"


def _drive(record: dict[str, Any]) -> tuple[str, ...]:
    camera = record["camera"]
    return (
        record["name"],
        record["layout"],
        record["weather"] or "not told",
        f"{camera['width_px']} x {camera['height_px']}, {record['rate_hz']:.3g} Hz",
        record["obstacles_by"] or "nobody",
        str(record["frames"]),
        str(record["gaps"]),
        str(record["segments"]),
        str(record["restarts"]),
        formatted(record["perception"]["road_found_share"], 1, True),
    )


def origins(records: Sequence[dict[str, Any]]) -> Table:
    """Where each signal comes from."""
    rows = [
        (record["name"], name, record["origins"][name]["kind"], record["origins"][name]["how"])
        for record in records
        for name in TOLD
    ]
    return Table("What is recorded and what is not", ("drive", "signal", "is", "how"), tuple(rows), 4)


def mountings(records: Sequence[dict[str, Any]]) -> Table:
    """How cameras look whose mounting was found on the way."""
    header = ("drive", "angle", "used", "deg", "from", "to", "straight way s")
    keys = ("deg", "from_deg", "to_deg", "straight_s")
    rows = [
        (record["name"], name, "yes" if one["used"] else "no", *(formatted(one[key], 1) for key in keys))
        for record in records
        for name, one in (record.get("mounting") or {}).items()
    ]
    note = "from and to: the interval at 95 %. An angle that is not used is taken to be 0."
    return Table("The camera's mounting, found on the way", header, tuple(rows), 3, (note,))


def doubts(records: Sequence[dict[str, Any]]) -> Table:
    """What a reader should doubt, a line for each thing."""
    rows = [(record["name"], what, why) for record in records for what, why in record.get("doubts", [])]
    return Table("What to doubt", ("drive", "what", "why"), tuple(rows), 3)


def lanes(records: Sequence[dict[str, Any]]) -> Table:
    """The steering where a lane was found, and where none was."""
    header = ("drive", "lane", "frames", "δ range", "δ span", "δ mae", "idle mae")
    rows = [
        _lane(record["name"], words, record["accuracy"]["lane"][key])
        for record in records
        if record["accuracy"] and record["perception"]["road_found_share"] is not None
        for key, words in (("found", "found"), ("not_found", "not found"))
    ]
    note = "Where no lane is found the model car keeps course and speed; these frames are not scored."
    return Table("Steering with and without a lane", header, tuple(row for row in rows if row[2] != "0"), 2, (note,))


def _lane(name: str, words: str, part: dict[str, Any]) -> tuple[str, ...]:
    scores, idle = part["steering"] or {}, part["idle"] or {}
    shares = [formatted(scores.get(key), 1, True) for key in ("range", "span")]
    return (name, words, str(part["frames"]), *shares, *(formatted(one.get("mae"), 4) for one in (scores, idle)))


def checks(records: Sequence[dict[str, Any]]) -> Table:
    """Signals that were measured apart, held against physics."""
    checked = [(record["name"], record["signal_checks"]["yaw_rate"]) for record in records]
    rows = [(name, formatted(one["gain"], 3), formatted(one["correlation"], 3)) for name, one in checked if one]
    note = (
        "gain: of the yaw rate over v tan(δ) / 2.7 m. 1 where ratio, wheelbase and signs are right and no tyre slips, "
        "negative where a sign is wrong; a car that understeers has about a half at 25 m/s."
    )
    return Table("Signals beside physics", ("drive", "gain", "correlation"), tuple(rows), notes=(note,))


def perception(records: Sequence[dict[str, Any]]) -> Table:
    """What was seen beside the truth."""
    foe = ("FOE x px", "FOE y px", "own x px", "own y px", "FOE there %", "spread x px", "spread y px")
    header = ("drive", *foe, "yaw rate rad/s", "speed scale", "TTC error %", "within 25 %", "false alarms %")
    notes = (
        "FOE: median error of the focus of expansion, the recorded rotation removed; own: told of no rotation; "
        "spread: quartiles' range; yaw rate: median error of the flow's; speed scale: by the road's flow / told; "
        "TTC: to the body ahead, where its gap closes by over 0.5 m/s; false alarms: less than 4 s while both stand.",
    )
    driven = tuple(_seen(record) for record in records if record["driven"])
    return Table("Perception beside the truth", header, driven, notes=notes)


def _seen(record: dict[str, Any]) -> tuple[str, ...]:
    seen = record["perception"]
    errors = [record[key] or {} for key in ("foe_median_error_px", "foe_median_error_own_derotation_px")]
    spread, ttc = seen["foe"]["interquartile_range_px"] or {}, seen["ttc"] or {}
    return (
        record["name"],
        *(formatted(error.get(axis), 1) for error in errors for axis in ("x", "y")),
        formatted(seen["foe"]["share"], 1, True),
        *(formatted(spread.get(axis), 1) for axis in ("x", "y")),
        formatted(seen["yaw_rate_median_error_radps"], 4),
        formatted((seen["speed_scale"] or {}).get("median"), 2),
        *(formatted(ttc.get(key), 1, True) for key in ("median_error", "within_25_percent", "false_alarms")),
    )


def compute(records: Sequence[dict[str, Any]], timing: Mapping[str, dict[str, Any]]) -> Table:
    """Time on one core."""
    header = ("drive", "driver", "driver 95 %", "reading", "period", "times real time")
    keys = ("driver_ms", "driver_p95_ms", "reading_ms", "period_ms", "real_time")
    there = [record["name"] for record in records if record["driven"] and record["name"] in timing]
    rows = [(name, *(formatted(timing[name][key], 1) for key in keys)) for name in there]
    return Table("Time on one core, ms a frame", header, tuple(rows), notes=("medians of CPU time",))
