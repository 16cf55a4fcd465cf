"""The gate: checks a run against rules, and lists the seeds to repeat for each failure.

All planned episodes count; an episode without a record fails every rule.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import fmean

import numpy as np

from vpf_sim.evaluation.analysis.rows import Cell
from vpf_sim.evaluation.analysis.statistics import mean_interval
from vpf_sim.evaluation.gate import baseline, perception_rules
from vpf_sim.evaluation.gate.checks import Check, matching, number
from vpf_sim.evaluation.gate.rules import SCORES, Rule, Score, score_of
from vpf_sim.evaluation.gate.run_cells import FAULTS, METRICS, Episodes, Run, values_of, worst_first

PERFECT = {"success_rate": 1.0, "collisions": 0.0, "comfortable_share": 1.0}
AGGREGATES: dict[str, Callable[[list[float]], float | None]] = {"collisions": sum, "clearance_m": min}  # others: mean


def check(run: Run, rules: Sequence[Rule], file: Path) -> list[Check]:
    """Check every rule in every matching cell; paths of baselines are relative to the rules' `file`.

    Of several limits of one value, the tightest is checked.
    """
    checks: list[Check] = []
    limits = _tightest(run, rules)
    for i, rule in enumerate(rules):
        if rule.perception is not None:
            checks += perception_rules.check(run, rule, rule.perception, f"{file}: rules[{i}].perception")
        if not rule.bounds() and rule.no_worse_than is None:
            continue
        cells = matching(rule, run.cells, run.path, f"{file}: rules[{i}]")
        checks += [
            _bound(key, limit, cell, run.cells[cell])
            for cell in cells
            for key, limit in rule.bounds().items()
            if limit == limits[cell, key]
        ]
        if rule.no_worse_than is not None:
            checks += _no_worse(rule, run, cells, file.parent / rule.no_worse_than)
    return list(dict.fromkeys(checks))  # two rules may be equal


def _tightest(run: Run, rules: Sequence[Rule]) -> dict[tuple[Cell, str], float]:
    """The tightest limit of each bound in each cell."""
    found: dict[tuple[Cell, str], float] = {}
    for rule in rules:
        for cell in filter(rule.matches, run.cells):
            for key, limit in rule.bounds().items():
                tighter = max if key.endswith("_at_least") else min
                found[cell, key] = tighter(limit, found.get((cell, key), limit))
    return found


def _bound(key: str, limit: float, cell: Cell, episodes: Episodes) -> Check:
    score, expected = score_of(key), f"{key} {limit:g}"
    values = values_of(score, episodes)
    if not values:
        return _without_values(cell, expected, score, episodes)
    aggregate = _upper if key.endswith("_upper_at_most") else AGGREGATES.get(score, fmean)
    value = aggregate(list(values.values()))
    sign = 1.0 if key.endswith("_at_least") else -1.0
    kept = value is not None and sign * (value - limit) >= 0.0
    good = PERFECT.get(score, limit)
    short = {seed: sign * (good - value) for seed, value in values.items()}
    worst = worst_first(short)
    seeds = [seed for seed in worst if short[seed] > 0.0] or worst[:1]
    text = "no interval" if value is None else number(value, limit) + METRICS[score].plain_unit
    actual = f"{text} ({len(values)} episode{'s' * (len(values) != 1)})"
    return _checked(Check(cell, expected, actual, "passed" if kept else "failed", tuple(seeds)), score, episodes)


def _checked(check: Check, score: str, episodes: Episodes) -> Check:
    """The check with the counts of missing and unfinished episodes.

    A missing episode already counts in shares; it fails rules on other scores.
    """
    missing = tuple(seed for seed, episode in episodes.items() if episode is None)
    faults = sum(episode is not None and episode.status in FAULTS for episode in episodes.values())
    counts = ((len(missing), "without a record"), (faults, "ended by a fault"))
    check = replace(check, actual=", ".join([check.actual, *(f"{count} {what}" for count, what in counts if count)]))
    if missing and score not in PERFECT:
        kept = check.outcome == "passed"
        seeds = dict.fromkeys([*missing, *(() if kept else check.seeds)])
        check = replace(check, outcome="failed", seeds=tuple(seeds), is_of_loss=kept)
    return check if check.outcome == "failed" else replace(check, seeds=())


def _without_values(cell: Cell, expected: str, score: str, episodes: Episodes) -> Check:
    """The check of a cell without values: nothing to measure, or no successful episode."""
    if any(episode is not None and episode.succeeded for episode in episodes.values()):
        return Check(cell, expected, "no obstacles" if score == "clearance_m" else "not measured", "skipped")
    if METRICS[score].of_perception and not any(
        record is not None and record.shows_perception for record in episodes.values()
    ):
        return Check(cell, expected, "no perception shown", "skipped")
    return Check(cell, expected, "no successful episode", "failed", tuple(sorted(episodes)), is_of_loss=True)


def _no_worse(rule: Rule, run: Run, cells: Sequence[Cell], path: Path) -> list[Check]:
    """Check the scores of one rule against its baseline."""
    stored = baseline.read(path)
    return [
        _against(
            baseline.baseline_score(stored, run, cell, score), score, cell, run.cells[cell], str(rule.no_worse_than)
        )
        for cell in cells
        for score in rule.scores or SCORES
    ]


def _against(before: baseline.BaselineScore, score: Score, cell: Cell, episodes: Episodes, name: str) -> Check:
    expected, ours = f"{score} no worse than {name}", values_of(score, episodes)
    if before.mean is None:
        return Check(cell, expected, "the baseline has none", "skipped")
    if not ours:
        return _without_values(cell, expected, score, episodes)
    found = baseline.compare(score, ours, before)
    check = Check(cell, expected, found.text, "failed" if found.worse else "passed", found.seeds)
    return _checked(check, score, episodes)


def _upper(values: Sequence[float]) -> float | None:
    """The upper end of the mean's interval; the mean for equal values, None for a single one."""
    interval = mean_interval(np.array(values))
    if interval is not None:
        return interval.high
    return fmean(values) if len(values) > 1 else None
