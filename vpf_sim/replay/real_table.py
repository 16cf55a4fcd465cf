"""The paper's table of real images beside ours: recorded drives by weather and obstacles.

The paper does not define its accuracy nor describe its drives, camera and road. So its cells have
columns of their own.
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
UNKNOWN_WEATHER = "unknown"
KEYS = ("range", "span", "tolerance", "mae")
UNDIVIDED = "not divided"  # drives without labels or detection of obstacles
Row = dict[str, Any]


def weather_of(name: str) -> str:
    """The paper's word for a weather, if it has one."""
    plain = " ".join(name.lower().replace("_", " ").split())
    return SAME.get(plain, plain) or UNKNOWN_WEATHER


def rows(records: Sequence[dict[str, Any]]) -> list[Row]:
    """One row for each weather, part and kind of signals, the paper's weathers first.

    Drives are weighted by their frames. Drives with simulated weather have rows of their own without the paper's
    cells. Drives that ended in an error of the driver are left out.
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
    """Weather, what was simulated, and the origins of throttle and steering."""
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
    """`frames` of a part, or the `unseen` ones of them."""
    frames: dict[str, int] = record["accuracy"][which]
    return frames["whole"] if part == UNDIVIDED else frames[part]


def _pooled(
    records: Iterable[dict[str, Any]], weights: Sequence[int], part: str, name: str, idle: bool
) -> dict[str, float | None] | None:
    """Means over the drives with the signal, weighted by frames."""
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
    "The paper defines neither its accuracy nor its signals' units; range, span and tolerance are ours.",
    "The paper does not describe its drives, camera, frame rate, road or number of frames; our rows name ours.",
    "Steering is the road wheels' angle / 40 deg, throttle the acceleration / 3 m/s2, brake / 6 m/s2, limited to 1.",
)
