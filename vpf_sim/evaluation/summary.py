"""The table of a run, one row a cell of scenario, weather and driver: sorted, and without a clock.

Means take the successful episodes; the others' are given apart, with how far they came.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import fmean
from typing import Any

from vpf_sim import drivers
from vpf_sim.evaluation.job import Job

Record = dict[str, Any]
MEANS = ("path_mse_m2", "max_lane_offset_m", "min_clearance_m", "accuracy", "perception")


def summarize(jobs: Iterable[Job], records: Iterable[Record]) -> dict[str, Any]:
    """`{"rows": [...]}`; the planned episodes are the denominator, whatever became of them."""
    by_id = {record["id"]: record for record in records}
    cells: dict[tuple[str, str, str], list[Record | None]] = {}
    for job in jobs:
        cells.setdefault((job.scenario, job.weather, job.driver), []).append(by_id.get(job.id))
    return {"rows": [_row(cell, found) for cell, found in sorted(cells.items())]}


def _row(cell: tuple[str, str, str], found: Sequence[Record | None]) -> dict[str, Any]:
    driven = sorted((record for record in found if record is not None), key=lambda record: int(record["seed"]))
    success = [record for record in driven if record["status"] == "success"]
    others = [record for record in driven if record["status"] != "success"]
    return {
        **dict(zip(("scenario", "weather", "driver"), cell, strict=True)),
        "privileged": drivers.create(cell[2]).privileged,
        "episodes": len(found),
        "successes": len(success),
        "statuses": dict(Counter(record["status"] for record in driven)),
        **_scores(success),
        "least_clearance_m": min(_present(success, "min_clearance_m"), default=None),
        "comfortable_share": mean([(record["comfort"] or {}).get("comfortable") for record in success]),
        "route_completion": mean([record["route_completion"] for record in driven]),
        "driving_score_2_0": mean([record["driving_score_2_0"] for record in driven]),
        "driving_score_2_1": mean([record["driving_score_2_1"] for record in driven]),
        "unsuccessful": {**_scores(others), "route_completion": mean([other["route_completion"] for other in others])},
    }


def mean(values: Sequence[Any]) -> Any:
    """The mean of what is there, key by key where the values are tables; None where nothing is."""
    there = [value for value in values if value is not None]
    if not there:
        return None
    if isinstance(there[0], dict):
        keys = {key for value in there for key in value}
        return {key: mean([value.get(key) for value in there]) for key in sorted(keys)}
    return fmean(there)


def _scores(records: Sequence[Record]) -> dict[str, Any]:
    return {key: mean([record[key] for record in records]) for key in MEANS}


def _present(records: Sequence[Record], key: str) -> list[float]:
    return [record[key] for record in records if record[key] is not None]
