"""Paired differences between weathers and between drivers, on the same seeds."""

from collections.abc import Iterable, Mapping
from itertools import combinations

import numpy as np

from vpf_sim.evaluation.analysis.rows import Cell, Comparison
from vpf_sim.evaluation.analysis.statistics import Difference, paired_difference, paired_shares
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import (
    CLEARANCE,
    COMPLETION,
    DRIVING_SCORE,
    DRIVING_SCORE_2_0,
    PATH_MSE,
    STEERING,
    SUCCESS,
    THROTTLE,
)

BASE_WEATHER, BASE_DRIVER = "clear", "pid"  # the preferred references
OF_SUCCESSES = (PATH_MSE, CLEARANCE, THROTTLE, STEERING)
OF_DRIVEN = (COMPLETION, DRIVING_SCORE_2_0, DRIVING_SCORE)


def compare(jobs: Iterable[Job], by_id: Mapping[str, Record]) -> list[Comparison]:
    """Each weather minus the clear one (else the first planned), each driver minus each later one, the PID last.

    Success is paired over the seeds planned for both; scores over seeds where both succeeded; completion and driving
    scores over seeds that both drove. None without pairs.
    """
    cells: dict[Cell, dict[int, Record | None]] = {}
    for job in jobs:
        cells.setdefault(Cell(*job[:3]), {})[job.seed] = by_id.get(job.id)
    pairs = sorted({*_weather_pairs(cells), *_driver_pairs(cells)})
    return [_comparison(first, second, cells) for first, second in pairs]


def _weather_pairs(cells: Iterable[Cell]) -> list[tuple[Cell, Cell]]:
    cells = list(cells)
    weathers = list(dict.fromkeys(weather for _, weather, _ in cells))
    base = BASE_WEATHER if BASE_WEATHER in weathers else weathers[0]
    others = [cell for cell in cells if cell[1] != base]
    return [(cell, clear) for cell in others if (clear := cell._replace(weather=base)) in cells]


def _driver_pairs(cells: Iterable[Cell]) -> list[tuple[Cell, Cell]]:
    cells = list(cells)
    drivers = sorted(dict.fromkeys(driver for *_, driver in cells), key=lambda driver: driver == BASE_DRIVER)
    places = dict.fromkeys(cell[:2] for cell in cells)
    pairs = [(Cell(*place, one), Cell(*place, other)) for place in places for one, other in combinations(drivers, 2)]
    return [pair for pair in pairs if pair[0] in cells and pair[1] in cells]


def _comparison(first: Cell, second: Cell, cells: Mapping[Cell, Mapping[int, Record | None]]) -> Comparison:
    seeds = sorted(cells[first].keys() & cells[second].keys())
    ones, others = ([cells[cell][seed] for seed in seeds] for cell in (first, second))
    both = [(one, other) for one, other in zip(ones, others, strict=True) if one is not None and other is not None]
    good = [(one, other) for one, other in both if one.succeeded and other.succeeded]
    rate = paired_shares(np.array([*map(succeeded, ones)]), np.array([*map(succeeded, others)])) if seeds else None
    differences = {
        SUCCESS.key: rate,
        **{metric.key: _difference(good, metric) for metric in OF_SUCCESSES},
        **{metric.key: _difference(both, metric) for metric in OF_DRIVEN},
    }
    if first.weather != second.weather:
        return Comparison("weather", first, second.weather, differences)
    return Comparison("driver", first, second.driver, differences)


def succeeded(record: Record | None) -> bool:
    """Whether an episode succeeded; one without a record did not."""
    return record is not None and record.succeeded


def _difference(pairs: Iterable[tuple[Record, Record]], metric: Metric) -> Difference | None:
    values = [(one[metric], other[metric]) for one, other in pairs]
    there = np.array([pair for pair in values if None not in pair], float).reshape(-1, 2)
    return paired_difference(there[:, 0], there[:, 1])
