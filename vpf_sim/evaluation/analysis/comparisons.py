"""Paired differences between weathers and between drivers, on the same seeds."""

from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import Any

import numpy as np

from vpf_sim.evaluation.analysis.statistics import Difference, paired_difference, paired_shares
from vpf_sim.evaluation.job import Job

Record = dict[str, Any]
Cell = tuple[str, str, str]  # scenario, weather, driver
BASE_WEATHER, BASE_DRIVER = "clear", "pid"  # the preferred references
OF_SUCCESSES = (
    "path_mse_m2",
    "min_clearance_m",
    "accuracy.shadow.throttle.range",
    "accuracy.shadow.steering.range",
)
OF_ALL = ("route_completion", "driving_score_2_0", "driving_score_2_1")


def compare(jobs: Iterable[Job], by_id: Mapping[str, Record]) -> list[dict[str, Any]]:
    """Each weather minus the clear one (else the first planned), each driver minus each later one, the PID last.

    Success is paired over the seeds planned for both; scores over seeds where both succeeded; completion and driving
    scores over seeds that both drove. None without pairs.
    """
    cells: dict[Cell, dict[int, Record | None]] = {}
    for job in jobs:
        cells.setdefault((job.scenario, job.weather, job.driver), {})[job.seed] = by_id.get(job.id)
    pairs = sorted({*_weather_pairs(cells), *_driver_pairs(cells)})
    return [_comparison(first, second, cells) for first, second in pairs]


def _weather_pairs(cells: Iterable[Cell]) -> list[tuple[Cell, Cell]]:
    cells = list(cells)
    weathers = list(dict.fromkeys(weather for _, weather, _ in cells))
    base = BASE_WEATHER if BASE_WEATHER in weathers else weathers[0]
    others = [cell for cell in cells if cell[1] != base]
    return [(cell, clear) for cell in others if (clear := (cell[0], base, cell[2])) in cells]


def _driver_pairs(cells: Iterable[Cell]) -> list[tuple[Cell, Cell]]:
    cells = list(cells)
    drivers = sorted(dict.fromkeys(driver for *_, driver in cells), key=lambda driver: driver == BASE_DRIVER)
    places = dict.fromkeys(cell[:2] for cell in cells)
    pairs = [((*place, one), (*place, other)) for place in places for one, other in combinations(drivers, 2)]
    return [pair for pair in pairs if pair[0] in cells and pair[1] in cells]


def _comparison(first: Cell, second: Cell, cells: Mapping[Cell, Mapping[int, Record | None]]) -> dict[str, Any]:
    of = "weather" if first[1] != second[1] else "driver"
    seeds = sorted(cells[first].keys() & cells[second].keys())
    ones, others = ([cells[cell][seed] for seed in seeds] for cell in (first, second))
    both = [(one, other) for one, other in zip(ones, others, strict=True) if one is not None and other is not None]
    good = [(one, other) for one, other in both if succeeded(one) and succeeded(other)]
    rate = paired_shares(np.array([*map(succeeded, ones)]), np.array([*map(succeeded, others)])) if seeds else None
    return {
        "of": of,
        **dict(zip(("scenario", "weather", "driver"), first, strict=True)),
        "minus": second[1] if of == "weather" else second[2],
        "success_rate": _as_row(rate),
        **{path: _as_row(_difference(good, path)) for path in OF_SUCCESSES},
        **{path: _as_row(_difference(both, path)) for path in OF_ALL},
    }


def succeeded(record: Record | None) -> bool:
    """Whether an episode succeeded; one without a record did not."""
    return record is not None and record["status"] == "success"


def value_at(record: Record, path: str) -> float | None:
    """The value under a dotted key, such as "accuracy.shadow.steering.range"; None if missing."""
    value: Any = record
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return None if value is None else float(value)


def _difference(pairs: Iterable[tuple[Record, Record]], path: str) -> Difference | None:
    values = [(value_at(one, path), value_at(other, path)) for one, other in pairs]
    there = np.array([pair for pair in values if None not in pair], float).reshape(-1, 2)
    return paired_difference(there[:, 0], there[:, 1])


def _as_row(difference: Difference | None) -> dict[str, Any] | None:
    if difference is None:
        return None
    return {**difference._asdict(), "interval": difference.interval and list(difference.interval)}
