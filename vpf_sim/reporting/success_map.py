"""The success map: the ending of every planned seed by cell and driver, in blocks of ten seeds."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from vpf_sim.evaluation.job import Job
from vpf_sim.reporting.cells import Order, shown
from vpf_sim.reporting.stored_run import Record

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
    counts = Counter(records[job.id]["status"] if job.id in records else "missing" for job in jobs)
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
    status = record["status"] if record else "missing"
    hit = f" with a {record['collided_with']}" if record and record.get("collided_with") else ""
    came = f", {100.0 * record['route_completion']:.0f} % of the route" if record else ""
    return job.seed, status, f"{job.id}: {status.replace('_', ' ')}{hit}{came}"
