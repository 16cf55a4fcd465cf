"""The summary of a run: one row per cell (scenario, weather, driver), without wall times.

Means are over successful episodes; those of the others are separate, with their route completion. Means and shares have
95 % intervals. Weathers and drivers are compared on the same seeds.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import fmean
from typing import Any

import numpy as np

from vpf_sim import drivers
from vpf_sim.evaluation.analysis.comparisons import compare
from vpf_sim.evaluation.analysis.statistics import mean_interval, seeds_for_mean, seeds_for_share, share_interval
from vpf_sim.evaluation.job import Job

Record = dict[str, Any]
MEANS = (
    "path_mse_m2",
    "path_mse_parts_m2",
    "max_lane_offset_m",
    "min_clearance_m",
    "accuracy",
    "chattering",
    "perception",
)
OF_ALL = ("route_completion", "driving_score_2_0", "driving_score_2_1")
NO_MANIFEST: Mapping[str, Any] = {}
WIDTHS = {"success_rate": 0.1, "path_mse_m2": 0.1}  # of the intervals whose required seeds are computed


def summarize(
    jobs: Iterable[Job], records: Iterable[Record], manifest: Mapping[str, Any] = NO_MANIFEST
) -> dict[str, Any]:
    """`{"rows": [...], "comparisons": [...]}`; rates are over all planned episodes.

    Drivers whose privilege the run's manifest lacks, as one of an older version does, are created.
    """
    jobs, privileged = list(jobs), manifest.get("privileged") or {}
    by_id = {record["id"]: record for record in records}
    cells: dict[tuple[str, str, str], list[Record | None]] = {}
    for job in jobs:
        cells.setdefault((job.scenario, job.weather, job.driver), []).append(by_id.get(job.id))
    return {
        "rows": [_row(cell, _privilege(cell[2], privileged), found) for cell, found in sorted(cells.items())],
        "comparisons": compare(jobs, by_id),
    }


def _privilege(driver: str, stored: Mapping[str, str]) -> str:
    return stored[driver] if driver in stored else drivers.create(driver).privileged


def _row(cell: tuple[str, str, str], privileged: str, found: Sequence[Record | None]) -> dict[str, Any]:
    driven = sorted((record for record in found if record is not None), key=lambda record: int(record["seed"]))
    success = [record for record in driven if record["status"] == "success"]
    others = [record for record in driven if record["status"] != "success"]
    return {
        **dict(zip(("scenario", "weather", "driver"), cell, strict=True)),
        "privileged": privileged,
        "episodes": len(found),
        "successes": len(success),
        "success_rate": len(success) / len(found),
        "statuses": dict(Counter(record["status"] for record in driven)),
        **_scores(success),
        "collisions": sum(record["collisions"] for record in driven),
        "at_fault_collisions": sum(record["at_fault_collisions"] for record in driven),
        "least_clearance_m": min(_present(success, "min_clearance_m"), default=None),
        "comfortable_share": mean(_comfortable(success)),
        **{key: mean([record[key] for record in driven]) for key in OF_ALL},
        "intervals": _intervals(success, driven, len(found)),
        "seeds_needed": _seeds_needed(success, len(found)),
        "unsuccessful": {**_scores(others), "route_completion": mean([other["route_completion"] for other in others])},
    }


def _intervals(success: Sequence[Record], driven: Sequence[Record], planned: int) -> dict[str, Any]:
    """[low, high] for the key of each share and mean."""
    comfortable = [value for value in _comfortable(success) if value is not None]
    return {
        "success_rate": list(share_interval(len(success), planned)),
        "comfortable_share": list(share_interval(sum(comfortable), len(comfortable))) if comfortable else None,
        **{key: interval([record[key] for record in success]) for key in MEANS},
        **{key: interval([record[key] for record in driven]) for key in OF_ALL},
    }


def _seeds_needed(success: Sequence[Record], planned: int) -> dict[str, int | None]:
    """Number of seeds for intervals of WIDTHS; for a mean, of successful seeds."""
    return {
        "success_rate": seeds_for_share(len(success), planned, WIDTHS["success_rate"]),
        "path_mse_m2": seeds_for_mean(np.array(_present(success, "path_mse_m2")), WIDTHS["path_mse_m2"]),
    }


def mean(values: Sequence[Any]) -> Any:
    """The mean of the values that are not None, key by key for tables; None without any."""
    return _by_key(values, fmean)


def interval(values: Sequence[Any]) -> Any:
    """[low, high] of the mean, key by key for tables; None without a spread."""
    return _by_key(values, _ends)


def _ends(values: Sequence[float]) -> list[float] | None:
    found = mean_interval(np.array(values, float))
    return None if found is None else list(found)


def _by_key(values: Sequence[Any], of: Callable[[Sequence[Any]], Any]) -> Any:
    present = [value for value in values if value is not None]
    if not present:
        return None
    if isinstance(present[0], dict):
        keys = {key for value in present for key in value}
        return {key: _by_key([value.get(key) for value in present], of) for key in sorted(keys)}
    return of(present)


def _comfortable(records: Sequence[Record]) -> list[bool | None]:
    return [(record["comfort"] or {}).get("comfortable") for record in records]


def _scores(records: Sequence[Record]) -> dict[str, Any]:
    return {key: mean([record[key] for record in records]) for key in MEANS}


def _present(records: Sequence[Record], key: str) -> list[float]:
    return [record[key] for record in records if record[key] is not None]
