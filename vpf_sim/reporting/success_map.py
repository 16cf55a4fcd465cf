"""The success map: the ending of every planned seed by cell and driver, in blocks of ten seeds."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import COMPLETION
from vpf_sim.reporting.cells import Order, shown
from vpf_sim.reporting.kit.table import formatted

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
