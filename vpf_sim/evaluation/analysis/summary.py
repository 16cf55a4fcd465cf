"""The summary of a run: one row per cell (scenario, weather, driver), without wall times.

Means are over successful episodes; those of the others are separate, with their route completion. Means and shares have
95 % intervals. Weathers and drivers are compared on the same seeds.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import fmean
from typing import TypeVar

import numpy as np

from vpf_sim import drivers
from vpf_sim.evaluation.analysis.benchmark import PAPER
from vpf_sim.evaluation.analysis.comparisons import compare
from vpf_sim.evaluation.analysis.rows import Cell, Row, Summary
from vpf_sim.evaluation.analysis.statistics import (
    Interval,
    mean_interval,
    seeds_for_mean,
    seeds_for_share,
    share_interval,
)
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import (
    AT_FAULT,
    CLEARANCE,
    COLLISIONS,
    COMFORTABLE,
    COMPLETION,
    LEAST_CLEARANCE,
    MEASURES,
    PATH_MSE,
    SUCCESS,
)
from vpf_sim.evaluation.score_keys import Number

OF_SUCCESSES, OF_DRIVEN = (
    tuple(measure.key for measure in MEASURES if measure.over == over) for over in ("successes", "driven")
)
WIDTHS = {SUCCESS.row_key: 0.1, PATH_MSE.row_key: 0.1}  # of the intervals whose required seeds are computed
NO_PRIVILEGES: Mapping[str, str] = {}
Found = TypeVar("Found")


def summarize(jobs: Iterable[Job], records: Iterable[Record], privileged: Mapping[str, str] = NO_PRIVILEGES) -> Summary:
    """The rows of the planned cells, and their comparisons; rates are over all planned episodes.

    `privileged` has the privilege of drivers by name, as the run's manifest; the others are created.
    """
    jobs = list(jobs)
    by_id = {record.id: record for record in records}
    cells: dict[Cell, list[Record | None]] = {}
    for job in jobs:
        cells.setdefault(Cell(*job[:3]), []).append(by_id.get(job.id))
    rows = [_row(cell, _privilege(cell.driver, privileged), found) for cell, found in sorted(cells.items())]
    return Summary(tuple(rows), tuple(compare(jobs, by_id)))


def interval(values: Sequence[float]) -> Interval | None:
    """The interval of the mean; None without a spread."""
    return mean_interval(np.array(values, float)) if len(values) else None


def _privilege(driver: str, stored: Mapping[str, str]) -> str:
    return stored[driver] if driver in stored else drivers.create(driver).privileged


def _row(cell: Cell, privileged: str, found: Sequence[Record | None]) -> Row:
    driven = sorted((record for record in found if record is not None), key=lambda record: record.seed)
    success = [record for record in driven if record.succeeded]
    others = [record for record in driven if not record.succeeded]
    values = {**_values(success, OF_SUCCESSES), **_values(driven, OF_DRIVEN)}
    return Row(
        **cell._asdict(),
        privileged=privileged,
        episodes=len(found),
        successes=len(success),
        statuses=dict(Counter(record.status for record in driven)),
        scores=_scores(success, driven, len(found), values),
        intervals=_intervals(success, len(found), values),
        seeds_needed=_seeds_needed(success, len(found)),
        unsuccessful=_of_each(_values(others, (*OF_SUCCESSES, COMPLETION.key)), fmean),
        paper=PAPER.get((cell.scenario, cell.weather)),
    )


def _scores(
    success: Sequence[Record], driven: Sequence[Record], planned: int, values: Mapping[str, list[float]]
) -> dict[str, Number]:
    """Means, with the share of successes, the counts of collisions, and the least clearance."""
    comfortable = _present(success, COMFORTABLE)
    return {
        **_of_each(values, fmean),
        SUCCESS.row_key: len(success) / planned,
        **{metric.row_key: int(sum(_present(driven, metric))) for metric in (COLLISIONS, AT_FAULT)},
        LEAST_CLEARANCE.row_key: min(_present(success, CLEARANCE), default=None),
        COMFORTABLE.row_key: fmean(comfortable) if comfortable else None,
    }


def _intervals(
    success: Sequence[Record], planned: int, values: Mapping[str, list[float]]
) -> dict[str, Interval | None]:
    comfortable = _present(success, COMFORTABLE)
    return {
        **_of_each(values, interval),
        SUCCESS.row_key: share_interval(len(success), planned),
        COMFORTABLE.row_key: share_interval(sum(comfortable), len(comfortable)) if comfortable else None,
    }


def _seeds_needed(success: Sequence[Record], planned: int) -> dict[str, int | None]:
    """Number of seeds for intervals of WIDTHS; for a mean, of successful seeds."""
    path_mse = np.array(_present(success, PATH_MSE))
    return {
        SUCCESS.row_key: seeds_for_share(len(success), planned, WIDTHS[SUCCESS.row_key]),
        PATH_MSE.row_key: seeds_for_mean(path_mse, WIDTHS[PATH_MSE.row_key]),
    }


def _values(records: Sequence[Record], measures: Sequence[str]) -> dict[str, list[float]]:
    """The values of each score of some measures, which are scores or tables, by dotted key."""
    values: dict[str, list[float]] = {key: [] for key in measures if not any(key in one.scores for one in records)}
    wanted: dict[str, bool] = {}
    for record in records:
        for key, value in record.scores.items():
            if key not in wanted:
                wanted[key] = key.partition(".")[0] in measures
                if wanted[key]:
                    values[key] = []
            if wanted[key] and value is not None:
                values[key].append(value)
    return values


def _of_each(values: Mapping[str, list[float]], of: Callable[[Sequence[float]], Found]) -> dict[str, Found | None]:
    """A function of the values of each score; None without values."""
    return {key: of(column) if column else None for key, column in values.items()}


def _present(records: Sequence[Record], metric: Metric) -> list[float]:
    return [value for record in records if (value := record[metric]) is not None]
