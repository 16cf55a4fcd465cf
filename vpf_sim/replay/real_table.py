"""The paper's table of real images beside ours: recorded drives by weather and obstacles.

The paper does not define its accuracy nor describe its drives, camera and road. So its cells have
columns of their own.
"""

from collections.abc import Sequence

from vpf_sim.evaluation.score_keys import Number
from vpf_sim.replay.records import Accuracies, Agreement, Both, Commands, DriveRecord, Part, Row, Summary
from vpf_sim.replay.scores import PARTS, SIGNALS, rounded

# Table "Results comparison table for real dataset": prediction accuracy of throttle and steering, as shares.
PAPER: dict[tuple[str, str], Both[float]] = {
    ("cloudy", PARTS[0]): Both[float](throttle=0.6943, steering=0.6492),
    ("cloudy", PARTS[1]): Both[float](throttle=0.6712, steering=0.6234),
    ("light rain", PARTS[0]): Both[float](throttle=0.5827, steering=0.5587),
    ("light rain", PARTS[1]): Both[float](throttle=0.5531, steering=0.5423),
    ("rain", PARTS[0]): Both[float](throttle=0.5612, steering=0.4851),
    ("rain", PARTS[1]): Both[float](throttle=0.5097, steering=0.4612),
}
WEATHERS = ("cloudy", "light rain", "rain")
SAME = {"overcast": "cloudy", "drizzle": "light rain", "heavy rain": "rain", "hard rain": "rain", "rainy": "rain"}
UNKNOWN_WEATHER = "unknown"
UNDIVIDED: Part = "not divided"  # drives without labels or detection of obstacles
DIFFERENCES = (
    "The paper defines neither its accuracy nor its signals' units; range, span and tolerance are ours.",
    "The paper does not describe its drives, camera, frame rate, road or number of frames; our rows name ours.",
    "Steering is the road wheels' angle / 40 deg, throttle the acceleration / 3 m/s2, brake / 6 m/s2, limited to 1.",
)
Group = tuple[str, str, str, str]  # weather, what was simulated, origins of throttle and steering
Scored = list[tuple[DriveRecord, Accuracies]]


def weather_of(name: str) -> str:
    """The paper's word for a weather, if it has one."""
    plain = " ".join(name.lower().replace("_", " ").split())
    return SAME.get(plain, plain) or UNKNOWN_WEATHER


def summary(records: Sequence[DriveRecord]) -> Summary:
    """One row for each weather, part and kind of signals, the paper's weathers first.

    Drives are weighted by their frames. Drives with simulated weather have rows of their own without the paper's
    cells. Drives that ended in an error of the driver are left out.
    """
    scored = [(record, record.accuracy) for record in records if record.accuracy and record.error is None]
    groups = {_group(record) for record, _ in scored}
    groups |= {(weather, "", "", "") for weather in WEATHERS if not any(one[:2] == (weather, "") for one in groups)}
    found: list[Row] = []
    for group in sorted(groups, key=_order):
        drives = [one for one in scored if _group(one[0]) == group]
        found += [_row(group, part, drives) for part in _parts(drives)]
    return Summary(rows=tuple(row for row in found if row.frames or row.paper), differences=DIFFERENCES)


def _group(record: DriveRecord) -> Group:
    throttle, steering = (record.origins[name].kind for name in ("throttle", "steering_rad"))
    return weather_of(record.weather), record.added or "", throttle, steering


def _order(group: Group) -> tuple[int, Group]:
    place = WEATHERS.index(group[0]) if group[0] in WEATHERS and not group[1] else len(WEATHERS)
    return place, group


def _parts(drives: Scored) -> list[Part]:
    undivided = [record for record, _ in drives if record.obstacles_by is None]
    divided = len(undivided) < len(drives) or not drives
    return [*(PARTS if divided else ()), *([UNDIVIDED] if undivided else [])]


def _row(group: Group, part: Part, drives: Scored) -> Row:
    weather, added, throttle, steering = group
    in_part = [one for one in drives if (one[0].obstacles_by is None) == (part == UNDIVIDED)]
    there = [one for one in in_part if part == UNDIVIDED or one[1].frames.part(part)]
    weights = [scores.frames.part(part) for _, scores in there]
    return Row(
        weather=weather,
        added=added or None,
        part=part,
        drives=tuple(record.name for record, _ in there),
        frames=sum(weights),
        unseen=sum(scores.unseen.part(part) for _, scores in there),
        signals=Both[str | None](throttle=throttle or None, steering=steering or None),
        accuracy=_pooled([scores.part(part) for _, scores in there], weights),
        idle=_pooled([scores.idle.part(part) for _, scores in there], weights),
        paper=None if added else PAPER.get((weather, part)),
    )


def _pooled(found: Sequence[Commands], weights: Sequence[int]) -> Commands:
    """Means over the drives with the signal, weighted by frames."""
    means = {signal: _mean([one[signal] for one in found], weights) for signal in SIGNALS}
    return Commands(**means)


def _mean(found: Sequence[Agreement | None], weights: Sequence[int]) -> Agreement | None:
    present = [(one, weight) for one, weight in zip(found, weights, strict=True) if one is not None]
    if not present:
        return None

    means: dict[str, Number] = {}
    for key in Agreement.model_fields:
        values = [(value, weight) for one, weight in present if (value := getattr(one, key)) is not None]
        total = sum(weight for _, weight in values)
        means[key] = rounded(sum(value * weight for value, weight in values) / total) if total else None
    return Agreement(**means)
