"""How episodes ended: the failures by kind, and the map of every seed."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from textwrap import shorten

from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.failure import PERCEPTION, Failure
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import COMPLETION
from vpf_sim.reporting.kit.page import NONE, Table, formatted
from vpf_sim.reporting.main_table import Order, shown, text_of

MOST_REASON = 160  # letters
SIGNS = {
    "success": "✓",
    "collision": "✕",
    "off_road": "⇲",
    "timeout": "◷",
    "stuck": "■",
    "invalid_frame": "▦",
    "error": "!",
    "missing": "·",
}
BLOCK = 10
Mark = tuple[int, str, str]  # seed, status, title


@dataclass(frozen=True, slots=True)
class FailureGroup:
    """Episodes of one cell and driver with the same ending."""

    scenario: str
    weather: str
    driver: str
    status: str
    collided_with: str | None
    failure: Failure | None
    reason: str
    seeds: tuple[int, ...]
    completion: str  # route completion in percent: "12.0 to 55.2"
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
        return (*record.cell, record.status, record.collided_with or "", record.failure or "", reason(record.id) or "")

    cells = {record.cell: number for number, record in reversed([*enumerate(failed)])}
    ordered = sorted(failed, key=lambda record: (cells[record.cell], alike(record), record.seed))
    return [_ending(key, list(found)) for key, found in groupby(ordered, key=alike)]


def table(groups: Sequence[FailureGroup]) -> Table | None:
    """One row per group; None without any."""
    rows = tuple((one.place, one.what, class_of(one.failure), ranges(one.seeds), one.completion) for one in groups)
    return Table(("where", "ended by", "why", "seeds", "route completed, %"), rows, words=4) if rows else None


def class_of(failure: Failure | None) -> str:
    """A class of failures by name: "perception: missed"."""
    if failure is None:
        return NONE
    return f"perception: {failure}" if failure in PERCEPTION else failure


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
    scenario, weather, driver, status, collided_with, _, reason = key
    driven = sorted(record[COMPLETION] or 0.0 for record in found)
    shares = list(dict.fromkeys(text_of(COMPLETION, share) for share in (driven[0], driven[-1])))
    seeds = tuple(record.seed for record in found)
    return FailureGroup(
        shown(scenario),
        shown(weather),
        driver,
        status.replace("_", " "),
        collided_with or None,
        found[0].failure,
        reason,
        seeds,
        " to ".join(shares),
        found[0].id,
    )


@dataclass(frozen=True, slots=True)
class MapRow:
    """The endings of a cell and driver by seed."""

    scenario: str
    weather: str
    driver: str
    marks: tuple[Mark, ...]

    @property
    def blocks(self) -> list[tuple[Mark, ...]]:
        """The marks in blocks of ten, so that a seed is easy to find."""
        return [self.marks[start : start + BLOCK] for start in range(0, len(self.marks), BLOCK)]


def signs(jobs: Sequence[Job], records: Mapping[str, Record]) -> list[tuple[str, str, int]]:
    """(status, sign, count) of the statuses on the map."""
    counts = Counter(records[job.id].status if job.id in records else "missing" for job in jobs)
    return [(status, sign, counts[status]) for status, sign in SIGNS.items() if status in counts]


def rows(jobs: Sequence[Job], records: Mapping[str, Record], order: Order) -> Iterator[MapRow]:
    """One row per cell and driver, one mark per planned seed."""
    cells: dict[tuple[str, str, str], list[Mark]] = {}
    for job in jobs:
        cells.setdefault((job.scenario, job.weather, job.driver), []).append(_mark(job, records.get(job.id)))
    for scenario, weather in order.cells():
        for driver in order.drivers:
            found = cells.get((scenario, weather, driver))
            if found:
                yield MapRow(shown(scenario), shown(weather), driver, tuple(sorted(found)))


def _mark(job: Job, record: Record | None) -> Mark:
    if record is None:
        return job.seed, "missing", f"{job.id}: missing"
    came = f"{formatted(record[COMPLETION], 0, percent=True)} % of the route"
    return job.seed, record.status, f"{job.id}: {record.ending}, {came}"
