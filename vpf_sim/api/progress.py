"""Progress of many episodes on stderr: count, rate, time left and failures."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vpf_sim.evaluation.metrics.records import Record
    from vpf_sim.evaluation.sweeps.run_folder import RunFolder

Notify = Callable[["Record"], None]
FAULTS = ("error", "invalid_frame")


@dataclass(slots=True)
class Tally:
    """Counts of a session; `done` begins with the episodes stored before it."""

    total: int
    done: int
    reached: int = 0  # successful episodes of this session
    failed: int = 0  # ended by a fault of the harness or the driver's code; a collision is a result
    driven: int = 0  # episodes of this session
    started_s: float = field(default_factory=lambda: monotonic())

    def count(self, record: "Record") -> None:
        self.done, self.driven = self.done + 1, self.driven + 1
        self.reached += record.succeeded
        self.failed += record.status in FAULTS

    def text(self) -> str:
        """For example "3 of 4 reached the goal, 312 an hour, 0:04:10 left"."""
        if not self.driven:
            return "no episode yet"
        episode_s = (monotonic() - self.started_s) / self.driven
        rate = 3600.0 / max(episode_s, 1e-9)
        faults = f"{self.failed} failed, " if self.failed else ""
        reached = f"{self.reached} of {self.driven} reached the goal"
        return f"{faults}{reached}, {rate:.0f} an hour, {clock((self.total - self.done) * episode_s)} left"


def clock(seconds: float) -> str:
    """Hours, minutes and seconds: "1:02:05"."""
    minutes, second = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{second:02}"


@contextmanager
def progress(total: int, folder: "RunFolder") -> Iterator[Notify]:
    """A callback for each record: a progress bar on a terminal, lines elsewhere."""
    tally = Tally(total, len(folder.done))
    with _bar(tally) if sys.stderr.isatty() else _lines(tally) as (show, say):

        def notify(record: "Record") -> None:
            tally.count(record)
            show(record)
            if record.status == "error":
                say(f"{record.id}: error, see {folder.error_file(record.id)}")

        yield notify


Display = tuple[Notify, Callable[[str], None]]


@contextmanager
def _lines(tally: Tally) -> Iterator[Display]:
    def show(record: "Record") -> None:
        say(f"{tally.done}/{tally.total} {record.id} {record.status} ({tally.text()})")

    yield show, say


@contextmanager
def _bar(tally: Tally) -> Iterator[Display]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}", markup=False))
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(tally.text(), total=tally.total, completed=tally.done)

        def show(record: "Record") -> None:
            bar.update(task, completed=tally.done, description=f"{tally.text()}, last {record.id}")

        yield show, lambda line: bar.console.print(line, markup=False, highlight=False, soft_wrap=True)


def say(line: str) -> None:
    """Print a line on stderr, flushed."""
    print(line, file=sys.stderr, flush=True)
