"""The paper's table of real images, and ours beside it: recorded drives by weather, with and without obstacles.

The paper's accuracy has no definition in print (METHOD A19), and its drives, their camera and their road are not told.
So its cells stand in columns of their own, never in the place of one of ours.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from vpf_sim.replay.scores import PARTS, SIGNALS, rounded

# Table "Results comparison table for real dataset": prediction accuracy of throttle and steering, as shares.
PAPER: dict[tuple[str, str], dict[str, float]] = {
    ("cloudy", PARTS[0]): {"throttle": 0.6943, "steering": 0.6492},
    ("cloudy", PARTS[1]): {"throttle": 0.6712, "steering": 0.6234},
    ("light rain", PARTS[0]): {"throttle": 0.5827, "steering": 0.5587},
    ("light rain", PARTS[1]): {"throttle": 0.5531, "steering": 0.5423},
    ("rain", PARTS[0]): {"throttle": 0.5612, "steering": 0.4851},
    ("rain", PARTS[1]): {"throttle": 0.5097, "steering": 0.4612},
}
WEATHERS = ("cloudy", "light rain", "rain")
SAME = {"overcast": "cloudy", "drizzle": "light rain", "heavy rain": "rain", "hard rain": "rain", "rainy": "rain"}
UNTOLD = "not told"
KEYS = ("range", "span", "tolerance", "mae")
UNDIVIDED = "not divided"  # part of drives in which nobody told obstacles from none
Row = dict[str, Any]


def weather_of(name: str) -> str:
    """The paper's word for a weather where it has one."""
    plain = " ".join(name.lower().replace("_", " ").split())
    return SAME.get(plain, plain) or UNTOLD


def rows(records: Sequence[dict[str, Any]]) -> list[Row]:
    """One a weather, a part and a kind of signals, the paper's weathers first; cells without a drive have no frames.

    Drives count by their frames. Those to whose frames weather was added have rows of their own, beside no paper; those
    that an error of the driver ended early have none.
    """
    found: list[Row] = []
    scored = [record for record in records if record["accuracy"] is not None and record["error"] is None]
    groups = sorted({_group(record) for record in scored}, key=_order)
    for weather in WEATHERS:
        if not any(group[0] == weather and not group[1] for group in groups):
            groups.append((weather, "", "", ""))
    for group in sorted(groups, key=_order):
        drives = [record for record in scored if _group(record) == group]
        found += [_row(group, part, drives) for part in _parts(drives)]
    return [row for row in found if row["frames"] or row["paper"]]


def _group(record: dict[str, Any]) -> tuple[str, str, str, str]:
    """Weather, what was added to it, and whether throttle and steering were recorded."""
    kinds = (record["origins"][name]["kind"] for name in ("throttle", "steering_rad"))
    throttle, steering = kinds
    return weather_of(record["weather"]), record["added"] or "", throttle, steering


def _order(group: tuple[str, str, str, str]) -> tuple[int, tuple[str, str, str, str]]:
    place = WEATHERS.index(group[0]) if group[0] in WEATHERS and not group[1] else len(WEATHERS)
    return place, group


def _parts(drives: Sequence[dict[str, Any]]) -> list[str]:
    undivided = [record for record in drives if record["obstacles_by"] is None]
    divided = len(undivided) < len(drives) or not drives
    return [*(PARTS if divided else ()), *([UNDIVIDED] if undivided else ())]


def _row(group: tuple[str, str, str, str], part: str, drives: Sequence[dict[str, Any]]) -> Row:
    weather, added, throttle, steering = group
    in_part = [record for record in drives if (record["obstacles_by"] is None) == (part == UNDIVIDED)]
    there = [record for record in in_part if part == UNDIVIDED or record["accuracy"]["frames"][part]]
    weights = [_count(record, "frames", part) for record in there]
    return {
        "weather": weather,
        "added": added or None,
        "part": part,
        "drives": [record["name"] for record in there],
        "frames": sum(weights),
        "unseen": sum(_count(record, "unseen", part) for record in there),
        "signals": {"throttle": throttle or None, "steering": steering or None},
        "accuracy": {name: _pooled(there, weights, part, name, False) for name in SIGNALS},
        "idle": {name: _pooled(there, weights, part, name, True) for name in SIGNALS},
        "paper": None if added else PAPER.get((weather, part)),
    }


def _count(record: dict[str, Any], which: str, part: str) -> int:
    """`frames` of a part, or those of them that are `unseen`."""
    frames: dict[str, int] = record["accuracy"][which]
    return frames["whole"] if part == UNDIVIDED else frames[part]


def _pooled(
    records: Iterable[dict[str, Any]], weights: Sequence[int], part: str, name: str, idle: bool
) -> dict[str, float | None] | None:
    """Means over the drives that have the signal, weighted by their frames."""
    scored = [(_scores(record, part, name, idle), weight) for record, weight in zip(records, weights, strict=True)]
    present = [(scores, weight) for scores, weight in scored if scores is not None]
    if not present:
        return None
    result: dict[str, float | None] = {}
    for key in KEYS:
        values = [(scores[key], weight) for scores, weight in present if scores[key] is not None]
        total = sum(weight for _, weight in values)
        result[key] = rounded(sum(value * weight for value, weight in values) / total) if total else None
    return result


def _scores(record: dict[str, Any], part: str, name: str, idle: bool) -> dict[str, Any] | None:
    accuracy = record["accuracy"]["idle"] if idle else record["accuracy"]
    scores: dict[str, Any] | None = (accuracy if part == UNDIVIDED else accuracy[part])[name]
    return scores


DIFFERENCES = (
    "The paper tells neither how its accuracy is defined nor its signals' unit; range, span and tolerance are ours.",
    "The paper's drives, camera, frame rate, road and number of frames are not told; ours are named in the rows.",
    "Steering is the road wheels' angle / 40 deg, throttle the acceleration / 3 m/s2, brake / 6 m/s2, all cut at 1.",
)
