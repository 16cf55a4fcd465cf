"""Comparison with a baseline run: paired on common seeds, else against the baseline's interval."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import NamedTuple

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.rows import Cell, Row, read_summary
from vpf_sim.evaluation.analysis.statistics import (
    Interval,
    mean_interval,
    paired_difference,
    paired_shares,
    share_interval,
)
from vpf_sim.evaluation.gate.rules import Score
from vpf_sim.evaluation.gate.run_cells import FAULTS, METRICS, Run, read_run, values_of, worst_first
from vpf_sim.evaluation.metrics.registry import COMFORTABLE
from vpf_sim.files import read_text

SHARES = (
    "success_rate",
    "collisions",
    "comfortable_share",
)  # of the planned episodes; an episode ends at its first collision


@dataclass(frozen=True, slots=True)
class Summary:
    """A run's summary without its records, by cell."""

    path: Path
    rows: dict[Cell, Row]


class BaselineScore(NamedTuple):
    """A score in a cell of the baseline."""

    by_seed: Mapping[int, float]  # empty for a summary without records
    mean: float | None
    interval: Interval | None


class Comparison(NamedTuple):
    text: str
    worse: bool
    seeds: tuple[int, ...]  # that got worse, worst first


def read(path: Path) -> Run | Summary:
    """The run in a folder, or a summary.json file."""
    if path.suffix != ".json":
        return read_run(path)
    try:
        content = json.loads(read_text(path))
        rows = read_summary(content, str(path)).rows if isinstance(content, dict) else None
    except OSError as error:
        raise InputError(f"{path}: expected a readable summary, got: {error.strerror}") from None
    except (ValueError, RecursionError, InputError):
        rows = None
    if rows is None:
        raise InputError(f"{path}: expected the summary.json of a run, got something else")
    return Summary(path, {row.cell: row for row in rows})


def baseline_score(baseline: Run | Summary, run: Run, cell: Cell, score: Score) -> BaselineScore:
    """The baseline's score in a cell; InputError where scenario or weather differ from the run's."""
    cells = baseline.rows if isinstance(baseline, Summary) else baseline.cells
    if cell not in cells:
        available = "; ".join(", ".join(one) for one in cells)
        raise InputError(f"{baseline.path}: expected the cell {', '.join(cell)}, got none; known: {available}")
    if isinstance(baseline, Summary):
        return _of_row(baseline.rows[cell], score)
    for kind, name in (("scenarios", cell.scenario), ("weathers", cell.weather)):
        if baseline.manifest.hashes(kind).get(name) != run.manifest.hashes(kind).get(name):
            raise InputError(
                f"{baseline.path}: expected {kind[:-1]} '{name}' as in {run.path}, got another of that name"
            )
    values = values_of(score, baseline.cells[cell])
    return BaselineScore(values, fmean(values.values()) if values else None, _interval(score, list(values.values())))


def compare(score: Score, ours: Mapping[int, float], theirs: BaselineScore) -> Comparison:
    """Whether ours are worse beyond the interval of the paired differences, or else of the baseline's mean."""
    sign = METRICS[score].sign
    common = sorted(ours.keys() & theirs.by_seed.keys())
    if not common:
        return _unpaired(sign, ours, theirs)
    now, then = np.array([ours[seed] for seed in common]), np.array([theirs.by_seed[seed] for seed in common])
    found = paired_shares(now > 0.0, then > 0.0) if score in SHARES else paired_difference(now, then)
    assert found is not None
    low, high = found.interval or (found.difference, found.difference)
    lost = {seed: loss for seed, loss in zip(common, (sign * (then - now)).tolist(), strict=True) if loss > 0.0}
    text = f"{np.mean(now):.3g}, was {np.mean(then):.3g}: {found.difference:+.3g} [{low:+.3g}, {high:+.3g}]"
    worse = max(sign * low, sign * high) < 0.0
    return Comparison(f"{text} on {len(common)} same seed" + "s" * (len(common) != 1), worse, tuple(worst_first(lost)))


def _unpaired(sign: float, ours: Mapping[int, float], theirs: BaselineScore) -> Comparison:
    mean = fmean(ours.values())
    assert theirs.mean is not None
    low, high = theirs.interval or (theirs.mean, theirs.mean)
    worst = low if sign > 0.0 else high
    lost = {seed: sign * (worst - value) for seed, value in ours.items() if sign * (worst - value) > 0.0}
    where = "on other seeds" if theirs.by_seed else "in the summary"
    text = f"{mean:.3g}, was {theirs.mean:.3g} [{low:.3g}, {high:.3g}] {where}"
    return Comparison(text, sign * (worst - mean) > 0.0, tuple(worst_first(lost)))


def _of_row(row: Row, score: Score) -> BaselineScore:
    if score in SHARES:
        count = _count(row, score)
        return BaselineScore({}, count / row.episodes, share_interval(count, row.episodes))
    return BaselineScore({}, row[METRICS[score]], row.interval(METRICS[score]))


def _count(row: Row, score: Score) -> int:
    """The number of episodes in a share, counted as in `value_of`."""
    if score == "success_rate":
        return row.successes
    if score == "comfortable_share":
        return round((row[COMFORTABLE] or 0.0) * row.successes)
    return row.missing + sum(row.statuses.get(status, 0) for status in ("collision", *FAULTS))


def _interval(score: Score, values: list[float]) -> Interval | None:
    if score in SHARES:
        return share_interval(sum(value > 0.0 for value in values), len(values)) if values else None
    return mean_interval(np.array(values))
