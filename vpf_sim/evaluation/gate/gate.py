"""The gate: whether a run keeps the rules, and if not, which seeds to drive again to see why.

The planned episodes are the denominator: one without a record is a failure, in every rule.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from statistics import fmean
from typing import Literal, NamedTuple

import numpy as np

from vpf_sim.errors import InputError, unknown_name
from vpf_sim.evaluation.analysis.statistics import mean_interval
from vpf_sim.evaluation.gate import baseline
from vpf_sim.evaluation.gate.cells import FAULTS, Cell, Episodes, Run, values_of, worst_first
from vpf_sim.evaluation.gate.rules import Rule, Score
from vpf_sim.shell import command

Outcome = Literal["passed", "failed", "skipped"]


@dataclass(frozen=True, slots=True)
class Check:
    """A rule in a cell. `seeds` are those to drive again, the worst first."""

    cell: Cell
    expected: str
    actual: str
    outcome: Outcome
    seeds: tuple[int, ...] = ()

    @property
    def rerun(self) -> str | None:
        """The command that drives the seeds again."""
        return again(self.cell, self.seeds) if self.seeds else None

    def first(self, count: int) -> "Check":
        """The same with so many of the seeds."""
        return replace(self, seeds=self.seeds[:count])


def again(cell: Cell, seeds: Sequence[int]) -> str:
    """A command that drives some seeds of a cell, for a shell."""
    drive = command("drive", cell.scenario, weather=cell.weather, driver=cell.driver)
    if len(seeds) == 1:
        return f"{drive} --seed {seeds[0]}"
    return f"for seed in {' '.join(map(str, seeds))}; do {drive} --seed $seed; done"


def check(run: Run, rules: Sequence[Rule], file: Path) -> list[Check]:
    """Every rule in every cell that it is for; the paths of baselines start where the rules' `file` is."""
    checks: list[Check] = []
    for i, rule in enumerate(rules):
        cells = _matching(rule, run, f"{file}: rules[{i}]")
        checks += [_bound(key, limit, cell, run.cells[cell]) for cell in cells for key, limit in rule.bounds().items()]
        if rule.no_worse_than is not None:
            checks += _no_worse(rule, run, cells, file.parent / rule.no_worse_than)
    return list(dict.fromkeys(checks))  # two rules may ask for the same


def _matching(rule: Rule, run: Run, where: str) -> list[Cell]:
    """The cells that a rule is for; a rule for none would hold whatever happens."""
    wanted = Cell(rule.scenario, rule.weather, rule.driver)
    for kind, pattern in wanted._asdict().items():
        names = {getattr(cell, kind) for cell in run.cells}
        if not any(fnmatchcase(name, pattern) for name in names):
            raise InputError(f"{where}.{kind}: not in {run.path}: {unknown_name(kind, pattern, names)}")
    cells = [cell for cell in run.cells if all(map(fnmatchcase, cell, wanted))]
    if not cells:
        raise InputError(f"{where}: expected a cell of {run.path}, got none that is {', '.join(wanted)}")
    return cells


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
    told = "no interval" if value is None else _number(value, limit) + kind.unit
    actual = f"{told} over {len(values)} episode" + "s" * (len(values) != 1)
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
        for score in rule.scores
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


def _number(value: float, limit: float) -> str:
    """Three digits, or as many as tell the value from the limit."""
    texts = (f"{value:.{digits}g}" for digits in range(max(3, len(f"{value:.0f}")), 18))
    return next(text for text in texts if np.sign(float(text) - limit) == np.sign(value - limit))


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
