"""Two runs on the same episodes: B minus A, paired by scenario, weather, driver and seed."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.rows import as_json
from vpf_sim.evaluation.analysis.statistics import LEVEL, Difference, paired_difference, paired_shares
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import SUCCESS, columns
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.reporting.headline import title
from vpf_sim.reporting.main_table import shown
from vpf_sim.reporting.run_data import RunData, open_run

Verdict = Literal["better", "worse", "same", "undecided"]
Cell = tuple[str, str, str]  # scenario, weather, driver


AGAINST = " against "
SCORES = {metric.key: metric for metric in columns("two runs")}


class Pair(NamedTuple):
    """An episode that both runs have driven."""

    jobs: tuple[Job, Job]
    records: tuple[Record, Record]

    @property
    def changed(self) -> bool:
        """Whether only one of them reached the goal."""
        return self.records[0].succeeded != self.records[1].succeeded


class Compared(NamedTuple):
    """The means of a score over the pairs that have it, and the difference B - A."""

    a: float
    b: float
    difference: Difference
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class TwoRuns:
    """The pairs of two runs, in the order of A's plan, with the names that tell the runs apart."""

    a: RunData
    b: RunData
    labels: tuple[str, str]
    pairs: tuple[Pair, ...]
    changed_worlds: tuple[str, ...]  # scenarios and weathers of one name that differ; their episodes are left out

    @classmethod
    def of(cls, a: RunData, b: RunData) -> "TwoRuns":
        """The episodes that both runs have driven; InputError where there is none."""
        renamed = _renamed(a, b)
        worlds = _changed_worlds(a, b)
        planned = set(b.jobs)
        pairs = []
        for job in a.jobs:
            weather, driver = renamed.get(job.weather, job.weather), renamed.get(job.driver, job.driver)
            other = job._replace(weather=weather, driver=driver)
            records = a.records.get(job.id), b.records.get(other.id)
            if other in planned and not worlds & {job.scenario, job.weather} and records[0] and records[1]:
                pairs.append(Pair((job, other), (records[0], records[1])))
        if not pairs:
            raise InputError(_nothing_shared(a, b, worlds))
        return cls(a, b, _labels(a, b, renamed), tuple(pairs), tuple(sorted(map(shown, worlds))))

    def cells(self) -> dict[Cell, list[Pair]]:
        """The pairs by scenario, weather and driver, a renamed one as "rain against clear"."""
        found: dict[Cell, list[Pair]] = {}
        for pair in self.pairs:
            names = zip(pair.jobs[0][:3], pair.jobs[1][:3], strict=True)
            scenario, weather, driver = (
                one if one == other else f"{shown(other)}{AGAINST}{shown(one)}" for one, other in names
            )
            found.setdefault((scenario, weather, driver), []).append(pair)
        return found

    @property
    def left_out(self) -> tuple[int, int]:
        """The numbers of planned episodes of A and of B that have no partner."""
        return len(self.a.jobs) - len(self.pairs), len(self.b.jobs) - len(self.pairs)

    def as_json(self) -> Json:
        """The comparison as data."""
        return {
            "runs": [str(one.run.path) for one in (self.a, self.b)],
            "labels": list(self.labels),
            "pairs": len(self.pairs),
            "left_out": list(self.left_out),
            "overall": _as_json(compared(self.pairs)),
            "cells": [
                {**dict(zip(("scenario", "weather", "driver"), cell, strict=True)), **_as_json(compared(pairs))}
                for cell, pairs in self.cells().items()
            ],
            "changed": [
                {"ids": [job.id for job in pair.jobs], "statuses": [record.status for record in pair.records]}
                for pair in self.pairs
                if pair.changed
            ],
        }


def open_two(a: Path, b: Path) -> TwoRuns:
    """The runs in two folders; InputError for the same one twice."""
    if a.resolve() == b.resolve():
        raise InputError(f"report: expected two runs, got {a} twice")
    return TwoRuns.of(RunData.of(open_run(a)), RunData.of(open_run(b)))


def compared(pairs: Sequence[Pair]) -> dict[str, Compared]:
    """The scores that pairs have, by key: success over all, others where both reached the goal or were driven."""
    found = {key: _compare(pairs, metric) for key, metric in SCORES.items()}
    return {key: one for key, one in found.items() if one is not None}


def _compare(pairs: Sequence[Pair], metric: Metric) -> Compared | None:
    if metric is SUCCESS:
        values = np.array([[record.succeeded for record in pair.records] for pair in pairs], float)
        difference = paired_shares(values[:, 1] > 0.0, values[:, 0] > 0.0)
    else:
        values = np.array([*_values(pairs, metric)], float).reshape(-1, 2)
        found = paired_difference(values[:, 1], values[:, 0])
        if found is None:
            return None
        difference = found
    a, b = np.mean(values, axis=0).tolist()
    return Compared(a, b, difference, verdict(difference, metric.sign))


def _values(pairs: Iterable[Pair], metric: Metric) -> Iterable[tuple[float, float]]:
    for one, other in (pair.records for pair in pairs):
        if metric.over == "driven" or (one.succeeded and other.succeeded):
            before, after = one[metric], other[metric]
            if before is not None and after is not None:
                yield before, after


def verdict(found: Difference, sign: int) -> Verdict:
    """Whether a difference is better or worse beyond its interval and by its test; `sign` is + where more is better."""
    if found.difference == 0.0 and found.p == 1.0:
        return "same"
    if found.interval is None:  # a single pair, or equal differences
        return "undecided"
    low, high = found.interval
    if low <= 0.0 <= high or found.p >= 1.0 - LEVEL:  # of few pairs the interval alone is too narrow
        return "undecided"
    return "better" if sign * low > 0.0 else "worse"


def _renamed(a: RunData, b: RunData) -> dict[str, str]:
    """Names of A and their partners in B: a driver or a weather, where each run has one and they differ."""
    kinds = ((a.plan.weather, b.plan.weather), (a.plan.driver, b.plan.driver))
    return {one[0]: other[0] for one, other in kinds if len(one) == len(other) == 1 and one != other}


def _changed_worlds(a: RunData, b: RunData) -> set[str]:
    """Scenarios and weathers that both runs name, and that differ."""
    found = set()
    for kind in ("scenarios", "weathers"):
        ours, theirs = (one.run.manifest.hashes(kind) for one in (a, b))
        found |= {name for name in ours.keys() & theirs.keys() if ours[name] != theirs[name]}
    return found


def _labels(a: RunData, b: RunData, renamed: dict[str, str]) -> tuple[str, str]:
    """What distinguishes the runs: the renamed driver or weather, else the folders' names."""
    if renamed:
        short = [*map(shown, renamed)], [*map(shown, renamed.values())]
        names = short if short[0] != short[1] else ([*renamed], [*renamed.values()])  # files of one name in two folders
        return ", ".join(names[0]), ", ".join(names[1])
    one, other = a.run.path, b.run.path
    return (one.name, other.name) if one.name != other.name else (str(one), str(other))


def _nothing_shared(a: RunData, b: RunData, worlds: set[str]) -> str:
    where = f"; of another content under the same name: {', '.join(sorted(worlds))}" if worlds else ""
    plans = f"{a.run.path} has {title(a.plan)}, {b.run.path} has {title(b.plan)}"
    driven = f"{len(a.records)} of {len(a.jobs)} and {len(b.records)} of {len(b.jobs)} episodes are driven"
    return f"report: expected an episode that both runs have driven, got none: {plans}; {driven}{where}"


def _as_json(found: dict[str, Compared]) -> Json:
    return {
        key: {"a": one.a, "b": one.b, **as_json(one.difference), "verdict": one.verdict} for key, one in found.items()
    }
