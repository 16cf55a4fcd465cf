"""Unsuccessful episodes, grouped by cell and kind of ending."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from textwrap import shorten

from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import COMPLETION
from vpf_sim.reporting.cells import shown, text_of
from vpf_sim.reporting.kit.table import Table

MOST_REASON = 160  # letters


@dataclass(frozen=True, slots=True)
class FailureGroup:
    """Episodes of one cell and driver with the same ending."""

    scenario: str
    weather: str
    driver: str
    status: str
    collided_with: str | None
    reason: str
    seeds: tuple[int, ...]
    way: str  # route completion in percent: "12.0 to 55.2"
    example: str  # the id of one episode

    @property
    def place(self) -> str:
        return f"{self.scenario}, {self.weather}, {self.driver}"

    @property
    def what(self) -> str:
        """How often and how they ended: "2 × collision with a car"."""
        hit = f" with a {self.collided_with}" if self.collided_with else ""
        why = f": {shorten(self.reason, MOST_REASON, placeholder='...')}" if self.reason else ""
        return f"{len(self.seeds)} × {self.status}{hit}{why}"


def endings(failed: Sequence[Record], reason: Callable[[str], str | None]) -> list[FailureGroup]:
    """The failed records grouped, in their order of cells; `reason` returns the error of an id."""

    def alike(record: Record) -> tuple[str, ...]:
        return (*record.cell, record.status, record.collided_with or "", reason(record.id) or "")

    cells = {record.cell: number for number, record in reversed([*enumerate(failed)])}
    ordered = sorted(failed, key=lambda record: (cells[record.cell], alike(record), record.seed))
    return [_ending(key, list(found)) for key, found in groupby(ordered, key=alike)]


def table(groups: Sequence[FailureGroup]) -> Table | None:
    """One row per group; None without any."""
    rows = tuple((one.place, one.what, ranges(one.seeds), one.way) for one in groups)
    return Table(("where", "ended by", "seeds", "route completed, %"), rows, words=3) if rows else None


def ranges(seeds: Sequence[int]) -> str:
    """Sorted seeds with ranges: "3, 5, 7–9"."""
    runs: list[list[int]] = []
    for seed in seeds:
        if runs and seed == runs[-1][-1] + 1:
            runs[-1].append(seed)
        else:
            runs.append([seed])
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)


def _ending(key: tuple[str, ...], found: list[Record]) -> FailureGroup:
    scenario, weather, driver, status, collided_with, reason = key
    driven = sorted(record[COMPLETION] or 0.0 for record in found)
    shares = list(dict.fromkeys(text_of(COMPLETION, share) for share in (driven[0], driven[-1])))
    seeds = tuple(record.seed for record in found)
    return FailureGroup(
        shown(scenario),
        shown(weather),
        driver,
        status.replace("_", " "),
        collided_with or None,
        reason,
        seeds,
        " to ".join(shares),
        found[0].id,
    )
