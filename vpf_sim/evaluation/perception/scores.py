"""Perception metrics of a drive, a cell, a weather, or a driver.

Recall is over objects, precision and false positives a minute are means over drives, errors are over detections or
frames.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from statistics import fmean
from typing import Any

import numpy as np

from vpf_sim.evaluation.analysis.statistics import share_interval
from vpf_sim.evaluation.analysis.summary import interval
from vpf_sim.evaluation.metrics import perception
from vpf_sim.evaluation.metrics.perception import DUE_M, KINDS
from vpf_sim.evaluation.perception.scorer import DriveEvaluation
from vpf_sim.scenarios.kinds import ObjectKind
from vpf_sim.types import Bools, Floats, Integers

ALL = "all"  # all weathers
BANDS_M = (0.0, 6.0, 10.0, 15.0, 25.0, np.inf)  # from the bumper; three of them are due distances
OF_DETECTIONS = {  # errors of correct detections, by their column
    "distance_error_m": "distance_m",
    "left_error_m": "left_m",
    "right_error_m": "right_m",
    "speed_error_mps": "speed_mps",
}
NEAR_M = 12.0  # from the bumper, where the overlap counts: the side to pass on is decided there
STATED = (0.5, 0.7, 0.9, 0.97, 1.0)  # bands of the probability of existence that a driver states
OF_FRAMES = ("edge_error_m", "lane_error_m", "foe_error_px")
ERRORS = (*OF_DETECTIONS, *OF_FRAMES)
SHARES = ("recall", "precision")
RATE = "false_positives_per_minute"

Row = dict[str, Any]  # of the JSON table


def record(evaluation: DriveEvaluation) -> Row:
    """The metrics of one drive, with the objects that were met in it."""
    confirmed_m, kinds = _met([evaluation])
    objects = [{"kind": KINDS[k], "first_confirmed_m": _number(m)} for k, m in zip(kinds, confirmed_m, strict=True)]
    named = {key: getattr(evaluation, key) for key in ("drive", "scenario", "weather", "seed", "driver")}
    source = {"states_sha256": evaluation.states_sha256, "remarks": list(evaluation.remarks)}
    return {**named, **metrics([evaluation]), "bodies": objects, **source}


def table(evaluations: Iterable[DriveEvaluation]) -> Row:
    """`records` by drive and driver; `rows` by cell; `totals` by driver and weather, with kinds and distance bands."""
    found = sorted(evaluations, key=lambda one: (one.driver, one.drive))
    weathers = [*dict.fromkeys(one.weather for one in found)]
    totals = [
        _group(found, driver=driver, weather=weather)
        for driver in dict.fromkeys(one.driver for one in found)
        for weather in (*weathers, *([ALL] if len(weathers) > 1 else []))
    ]
    cells = sorted({(one.scenario, one.weather, one.driver) for one in found})
    rows = [
        {"scenario": scenario, "weather": weather, "driver": driver, **_cell_metrics(found, scenario, weather, driver)}
        for scenario, weather, driver in cells
    ]
    return {"records": [record(one) for one in found], "rows": rows, "totals": totals}


def metrics(found: Sequence[DriveEvaluation]) -> Row:
    """The metrics of some drives of one driver, with 95 % intervals of recall, precision and false positives."""
    confirmed_m, kinds = _met(found)
    in_time = confirmed_m >= _due_m(kinds)
    precision = [value for one in found if (value := _precision(one)) is not None]
    rates = [_rate(one) for one in found]
    return {
        "drives": len(found),
        "minutes": sum(one.minutes for one in found),
        "bodies_met": len(kinds),
        "first_confirmed_m": _median(confirmed_m),
        "recall": float(np.mean(in_time)) if len(in_time) else None,
        "precision": fmean(precision) if precision else None,
        RATE: fmean(rates),
        "intervals": {
            "recall": list(share_interval(int(in_time.sum()), len(in_time))) if len(in_time) else None,
            "precision": interval(precision),
            RATE: interval(rates),
        },
        **_detection_errors([(one, np.ones(len(one.detections), np.bool_)) for one in found]),
        "overlap": _median(np.concatenate([one.of("overlap")[one.of("ahead_m") < NEAR_M] for one in found])),
        "calibration": _calibration(found),
        **_frame_errors(found),
    }


def spread(error: Floats) -> Row | None:
    """Median and 95th percentile of (N,) absolute errors, the signed median, and N."""
    error = error[np.isfinite(error)]
    if not len(error):
        return None
    size = np.abs(error)
    median, p95 = float(np.median(size)), float(np.percentile(size, 95.0))
    return {"median": median, "p95": p95, "bias": float(np.median(error)), "count": len(error)}


def _cell_metrics(found: Sequence[DriveEvaluation], *cell: str) -> Row:
    return metrics([one for one in found if (one.scenario, one.weather, one.driver) == cell])


def _group(found: Sequence[DriveEvaluation], driver: str, weather: str) -> Row:
    """The metrics of a driver in a weather, over all scenarios."""
    chosen = [one for one in found if one.driver == driver and weather in (one.weather, ALL)]
    kinds = {kind: row for kind in KINDS if (row := _of_kind(chosen, kind)) is not None}
    bands = [_of_band(chosen, low_m, high_m) for low_m, high_m in pairwise(BANDS_M)]
    return {"weather": weather, "driver": driver, **metrics(chosen), "by_kind": kinds, "by_distance": bands}


def _of_kind(found: Sequence[DriveEvaluation], kind: ObjectKind) -> Row | None:
    """Recall and errors of one kind of object; None if none was met or detected."""
    confirmed_m, kinds = _met(found)
    of_kind, number = confirmed_m[kinds == KINDS.index(kind)], float(KINDS.index(kind))
    errors = _detection_errors([(one, one.of("kind") == number) for one in found])
    if not len(of_kind) and errors["distance_error_m"] is None:
        return None
    return {"due_m": DUE_M[kind], **_recall_at(of_kind, DUE_M[kind]), "first_confirmed_m": _median(of_kind), **errors}


def _of_band(found: Sequence[DriveEvaluation], low_m: float, high_m: float) -> Row:
    """Metrics of a distance band; recall is the share of the met objects confirmed at `low_m` or farther."""
    inside = [(one, (one.of("ahead_m") >= low_m) & (one.of("ahead_m") < high_m)) for one in found]
    right = [float(np.mean(one.of("is_right")[rows])) for one, rows in inside if rows.any()]
    rates = [float(np.sum(one.of("is_new")[rows]) / one.minutes) for one, rows in inside]
    confirmed_m, _ = _met(found)
    return {
        "from_m": low_m,
        "to_m": high_m if np.isfinite(high_m) else None,
        **_recall_at(confirmed_m, low_m),
        "precision": fmean(right) if right else None,
        RATE: fmean(rates),
        **_detection_errors(inside),
    }


def _recall_at(confirmed_m: Floats, distance_m: float) -> Row:
    count = len(confirmed_m)
    in_time = int(np.sum(confirmed_m >= distance_m))
    ends = list(share_interval(in_time, count)) if count else None
    return {"bodies_met": count, "recall": in_time / count if count else None, "intervals": {"recall": ends}}


def _met(found: Sequence[DriveEvaluation]) -> tuple[Floats, Integers]:
    """(B,) m, first-confirmation distance of each met object, nan if never, and the index of its kind."""
    met = [np.isfinite(one.table.met_kind) for one in found]
    confirmed = [one.table.met_confirmed_m[rows] for one, rows in zip(found, met, strict=True)]
    kinds = [one.table.met_kind[rows] for one, rows in zip(found, met, strict=True)]
    return np.concatenate([np.empty(0), *confirmed]), np.concatenate([np.empty(0), *kinds]).astype(np.int64)


def _due_m(kinds: Integers) -> Floats:
    return np.array([DUE_M[KINDS[kind]] for kind in kinds], float)


def _objects(one: DriveEvaluation) -> Row:
    found = perception.objects(one.table)
    assert found is not None, "every frame was scored"
    return found


def _precision(one: DriveEvaluation) -> float | None:
    value: float | None = _objects(one)["precision"]
    return value


def _rate(one: DriveEvaluation) -> float:
    value: float = _objects(one)["wrong_per_minute"]
    return value


def _detection_errors(found: Sequence[tuple[DriveEvaluation, Bools]]) -> Row:
    """Errors of the correct ones among some detections of each drive."""
    return {
        key: spread(np.concatenate([np.empty(0), *(one.of(column)[rows] for one, rows in found)]))
        for key, column in OF_DETECTIONS.items()
    }


def _calibration(found: Sequence[DriveEvaluation]) -> list[Row]:
    """A reliability diagram: of detections that are stated with about one probability, the share that is right."""
    stated = np.concatenate([np.empty(0), *(one.of("existence") for one in found)])
    right = np.concatenate([np.empty(0), *(one.of("is_right") for one in found)])
    rows: list[Row] = []
    for low, high in pairwise(STATED):
        inside = (stated >= low) & ((stated < high) | (high == STATED[-1]))
        if inside.any():
            mean, share = float(stated[inside].mean()), float(right[inside].mean())
            rows.append({"from": low, "to": high, "stated": mean, "right": share, "count": int(inside.sum())})
    return rows


def _frame_errors(found: Sequence[DriveEvaluation]) -> Row:
    """Errors of edges, ego lane and focus of expansion, with the share of frames that have an estimate."""
    tables = [one.table for one in found]

    def column(name: str) -> Floats:
        return np.concatenate([getattr(table, name)[:-1] for table in tables])

    left, right = (column(f"seen_{side}_m") - column(f"true_{side}_m") for side in ("left", "right"))
    lane = np.concatenate([one.lane_error_m[:-1] for one in found])
    foe = perception.foe(*(column(name) for name in ("foe_x_px", "foe_y_px", "true_foe_x_px", "true_foe_y_px")))
    distance = np.hypot(column("foe_x_px") - column("true_foe_x_px"), column("foe_y_px") - column("true_foe_y_px"))
    medians: Any = foe["foe_median_error_px"]
    foe_error = spread(distance)
    return {
        "edge_error_m": spread(np.concatenate([left, right])),
        "edge_share": float(np.mean(np.isfinite(left))),
        "lane_error_m": spread(lane),
        "lane_share": float(np.mean(np.isfinite(lane))),
        "foe_error_px": foe_error and {**foe_error, "x": medians["x"], "y": medians["y"]},
        "foe_share": foe["foe_share"],
    }


def _median(values: Floats) -> float | None:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else None


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
