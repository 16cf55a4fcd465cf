"""The check of a rule in a cell, and the cells that a rule matches."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Literal

import numpy as np

from vpf_sim import drivers, system
from vpf_sim.errors import InputError, unknown_name
from vpf_sim.evaluation.analysis.rows import Cell
from vpf_sim.evaluation.gate.rules import Rule
from vpf_sim.system import command

Outcome = Literal["passed", "failed", "skipped"]
MOST_SEEDS = 10  # of a printed command; JSON and JUnit have all


@dataclass(frozen=True, slots=True)
class Check:
    """The result of a rule in a cell; `seeds` are those to repeat, worst first.

    A perception rule is repeated on the episodes `drives` of the run in `folder`, or on the whole run.
    """

    cell: Cell
    expected: str
    actual: str
    outcome: Outcome
    seeds: tuple[int, ...] = ()
    drives: tuple[str, ...] = ()
    folder: str = ""
    is_of_loss: bool = field(default=False, compare=False)  # fails since none succeeded, or one has no record

    @property
    def rerun(self) -> str | None:
        """The command that repeats the seeds or the perception drives; None for a driver of a notebook or script."""
        if not drivers.has_name(self.cell.driver):
            return None
        if self.folder:
            rerun = command("perception", self.folder, driver=self.cell.driver)
            return " ".join([rerun, *(f"--id {drive}" for drive in self.drives)])
        return drive_command(self.cell, self.seeds) if self.seeds else None

    def first(self, count: int) -> "Check":
        """A copy with the first `count` seeds."""
        return replace(self, seeds=self.seeds[:count], drives=self.drives[:count])


def listed(checks: Sequence[Check]) -> list[Check]:
    """The checks to show a reader: lost drives first, without rules that do not apply.

    Where a cell fails by its endings, rules that fail for lost drives alone say nothing more.
    """
    lost = {one.cell for one in checks if one.outcome == "failed" and _is_of_endings(one)}
    shown = [one for one in checks if one.outcome != "skipped" and not (one.is_of_loss and one.cell in lost)]
    return sorted(shown, key=lambda one: (one.outcome != "failed", not _is_of_endings(one)))


def unlisted(checks: Sequence[Check]) -> str:
    """How many checks are not listed, and why; empty where all are."""
    count = len(checks) - len(listed(checks))
    return f"not listed: {count} that do not apply or follow from lost drives; --json has all" if count else ""


def _is_of_endings(check: Check) -> bool:
    """Whether a rule is about how episodes end."""
    return check.expected.startswith(("success_rate", "collisions"))


def repeats(failed: Iterable[Check]) -> list[str]:
    """The commands that repeat failures, one for each cell, with at most `MOST_SEEDS` seeds, the worst first."""
    merged: dict[tuple[Cell, str], Check] = {}
    for one in failed:
        before = merged.get((one.cell, one.folder))
        if before is None:
            merged[one.cell, one.folder] = one
            continue
        seeds = tuple(dict.fromkeys(before.seeds + one.seeds))
        merged[one.cell, one.folder] = replace(
            one, seeds=seeds, drives=tuple(dict.fromkeys(before.drives + one.drives))
        )
    commands = (one.first(MOST_SEEDS).rerun for one in merged.values())
    return [one for one in commands if one]


def drive_command(cell: Cell, seeds: Sequence[int]) -> str:
    """The shell command that drives some seeds of a cell."""
    drive = command("drive", cell.scenario, weather=cell.weather, driver=cell.driver)
    if len(seeds) == 1:
        return f"{drive} --seed {seeds[0]}"
    return system.repeated(drive, "--seed", seeds)


def matching(rule: Rule, cells: Iterable[Cell], path: Path, where: str) -> list[Cell]:
    """The cells that a rule matches; InputError for none, since such a rule would always pass."""
    cells, wanted = list(cells), Cell(rule.scenario, rule.weather, rule.driver)
    for kind, pattern in wanted._asdict().items():
        names = {getattr(cell, kind) for cell in cells}
        if not any(fnmatchcase(name, pattern) for name in names):
            raise InputError(f"{where}.{kind}: not in {path}: {unknown_name(kind, pattern, names)}")
    found = [*filter(rule.matches, cells)]
    if not found:
        raise InputError(f"{where}: expected a cell of {path}, got none that is {', '.join(wanted)}")
    return found


def number(value: float, limit: float) -> str:
    """The value with three digits, or as many as distinguish it from the limit."""
    texts = (f"{value:.{digits}g}" for digits in range(max(3, len(f"{value:.0f}")), 18))
    return next(text for text in texts if np.sign(float(text) - limit) == np.sign(value - limit))
