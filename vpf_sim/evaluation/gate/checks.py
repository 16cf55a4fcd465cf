"""What the gate says of a rule in a cell, and which cells a rule is for."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Literal

import numpy as np

from vpf_sim.errors import InputError, unknown_name
from vpf_sim.evaluation.gate.cells import Cell
from vpf_sim.evaluation.gate.rules import Rule
from vpf_sim.shell import command

Outcome = Literal["passed", "failed", "skipped"]


@dataclass(frozen=True, slots=True)
class Check:
    """A rule in a cell. `seeds` are those to drive again, the worst first.

    Of a rule on perception they are to be seen again: as the episodes `drives` of the run in `folder`, or all of it.
    """

    cell: Cell
    expected: str
    actual: str
    outcome: Outcome
    seeds: tuple[int, ...] = ()
    drives: tuple[str, ...] = ()
    folder: str = ""

    @property
    def rerun(self) -> str | None:
        """The command that drives the seeds again, or sees the drives again."""
        if self.folder:
            seen_again = command("perception", self.folder, driver=self.cell.driver)
            return " ".join([seen_again, *(f"--id {drive}" for drive in self.drives)])
        return again(self.cell, self.seeds) if self.seeds else None

    def first(self, count: int) -> "Check":
        """The same with so many of the seeds."""
        return replace(self, seeds=self.seeds[:count], drives=self.drives[:count])


def again(cell: Cell, seeds: Sequence[int]) -> str:
    """A command that drives some seeds of a cell, for a shell."""
    drive = command("drive", cell.scenario, weather=cell.weather, driver=cell.driver)
    if len(seeds) == 1:
        return f"{drive} --seed {seeds[0]}"
    return f"for seed in {' '.join(map(str, seeds))}; do {drive} --seed $seed; done"


def matching(rule: Rule, cells: Iterable[Cell], path: Path, where: str) -> list[Cell]:
    """The cells of a run that a rule is for; a rule for none would hold whatever happens."""
    cells, wanted = list(cells), Cell(rule.scenario, rule.weather, rule.driver)
    for kind, pattern in wanted._asdict().items():
        names = {getattr(cell, kind) for cell in cells}
        if not any(fnmatchcase(name, pattern) for name in names):
            raise InputError(f"{where}.{kind}: not in {path}: {unknown_name(kind, pattern, names)}")
    found = [cell for cell in cells if all(map(fnmatchcase, cell, wanted))]
    if not found:
        raise InputError(f"{where}: expected a cell of {path}, got none that is {', '.join(wanted)}")
    return found


def number(value: float, limit: float) -> str:
    """Three digits, or as many as tell the value from the limit."""
    texts = (f"{value:.{digits}g}" for digits in range(max(3, len(f"{value:.0f}")), 18))
    return next(text for text in texts if np.sign(float(text) - limit) == np.sign(value - limit))
