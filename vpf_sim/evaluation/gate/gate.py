"""The gate: whether a run keeps the rules, and if not, which seeds to drive again to see why.

The planned episodes are the denominator: one without a record is a failure, in every rule.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import fmean
from typing import NamedTuple

import numpy as np

from vpf_sim.evaluation.analysis.statistics import mean_interval
from vpf_sim.evaluation.gate import baseline, perception
from vpf_sim.evaluation.gate.cells import FAULTS, Cell, Episodes, Run, values_of, worst_first
from vpf_sim.evaluation.gate.checks import Check, matching, number
from vpf_sim.evaluation.gate.rules import SCORES, Rule, Score


def check(run: Run, rules: Sequence[Rule], file: Path) -> list[Check]:
    """Every rule in every cell that it is for; the paths of baselines start where the rules' `file` is."""
    checks: list[Check] = []
    for i, rule in enumerate(rules):
        if rule.perception is not None:
            checks += perception.check(run, rule, rule.perception, f"{file}: rules[{i}].perception")
        if not rule.bounds() and rule.no_worse_than is None:
            continue
        cells = matching(rule, run.cells, run.path, f"{file}: rules[{i}]")
        checks += [_bound(key, limit, cell, run.cells[cell]) for cell in cells for key, limit in rule.bounds().items()]
        if rule.no_worse_than is not None:
            checks += _no_worse(rule, run, cells, file.parent / rule.no_worse_than)
    return list(dict.fromkeys(checks))  # two rules may ask for the same


def _bound(key: str, limit: float, cell: Cell, episodes: Episodes) -> Check:
    kind, expected = KINDS[key], f"{key} {limit:g}"
    values = values_of(kind.score, episodes)
    if not values:
        return _nothing_to_judge(cell, expected, episodes)
    value = kind.of(list(values.values()))
    sign = 1.0 if key.endswith("_at_least") else -1.0
    kept = value is not None and sign * (value - limit) >= 0.0
    good = PERFECT.get(kind.score, limit)
    short = {seed: sign * (good - value) for seed, value in values.items()}
    worst = worst_first(short)
    seeds = [seed for seed in worst if short[seed] > 0.0] or worst[:1]
    told = "no interval" if value is None else number(value, limit) + kind.unit
    actual = f"{told} ({len(values)} episode{'s' * (len(values) != 1)})"
    return _checked(Check(cell, expected, actual, "passed" if kept else "failed", tuple(seeds)), kind.score, episodes)


def _checked(check: Check, score: Score, episodes: Episodes) -> Check:
    """With the episodes that were not driven to an end told.

    Those without a record count in shares anyway, and break the rules on other scores.
    """
    missing = tuple(seed for seed, episode in episodes.items() if episode is None)
    faults = sum(episode is not None and episode.status in FAULTS for episode in episodes.values())
    told = ((len(missing), "without a record"), (faults, "ended by a fault"))
    check = replace(check, actual=", ".join([check.actual, *(f"{count} {what}" for count, what in told if count)]))
    if missing and score not in PERFECT:
        seeds = check.seeds if check.outcome == "failed" else ()
        check = replace(check, outcome="failed", seeds=tuple(dict.fromkeys([*missing, *seeds])))
    return check if check.outcome == "failed" else replace(check, seeds=())


def _nothing_to_judge(cell: Cell, expected: str, episodes: Episodes) -> Check:
    """Scores are of successful episodes; those that have none for another reason met no body."""
    if any(episode is not None and episode.succeeded for episode in episodes.values()):
        return Check(cell, expected, "no bodies", "skipped")
    return Check(cell, expected, "no successful episode", "failed", tuple(sorted(episodes)))


def _no_worse(rule: Rule, run: Run, cells: Sequence[Cell], path: Path) -> list[Check]:
    """The scores of one rule against its baseline."""
    stored = baseline.read(path)
    return [
        _against(baseline.before(stored, run, cell, score), score, cell, run.cells[cell], str(rule.no_worse_than))
        for cell in cells
        for score in rule.scores or SCORES
    ]


def _against(before: baseline.Before, score: Score, cell: Cell, episodes: Episodes, name: str) -> Check:
    expected, ours = f"{score} no worse than {name}", values_of(score, episodes)
    if before.mean is None:
        return Check(cell, expected, "the baseline has none", "skipped")
    if not ours:
        return _nothing_to_judge(cell, expected, episodes)
    found = baseline.compare(score, ours, before)
    judged = Check(cell, expected, found.told, "failed" if found.worse else "passed", found.seeds)
    return _checked(judged, score, episodes)


def _upper(values: Sequence[float]) -> float | None:
    """The upper end of the mean's interval; equal values have their mean, a single one tells nothing of others."""
    interval = mean_interval(np.array(values))
    if interval is not None:
        return interval.high
    return fmean(values) if len(values) > 1 else None


class Kind(NamedTuple):
    """What a bound is on: a score, what is made of its values, and the unit of that."""

    score: Score
    of: Callable[[list[float]], float | None]
    unit: str = ""


KINDS = {
    "success_rate_at_least": Kind("success_rate", fmean),
    "collisions_at_most": Kind("collisions", sum),
    "path_mse_m2_at_most": Kind("path_mse_m2", fmean, " m2"),
    "path_mse_m2_upper_at_most": Kind("path_mse_m2", _upper, " m2"),
    "clearance_m_at_least": Kind("clearance_m", min, " m"),
    "comfortable_share_at_least": Kind("comfortable_share", fmean),
}
PERFECT: dict[Score, float] = {"success_rate": 1.0, "collisions": 0.0, "comfortable_share": 1.0}
