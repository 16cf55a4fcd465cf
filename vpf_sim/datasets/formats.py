"""What a format of data sets is: it stores episodes one by one, in worker processes, and then describes the set."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from vpf_sim.datasets.played_episode import Contents, Episode
from vpf_sim.errors import InputError
from vpf_sim.evaluation.metrics.records import Record

INSTALL = "pip install 'vpf_sim[export]'"


class Place(NamedTuple):
    """The place of an episode in its set."""

    episode: int
    first_frame: int  # of all frames that have an action
    task_index: int


@dataclass(frozen=True, slots=True)
class Written:
    """An episode of a set, as its worker reports it."""

    place: Place
    record: Record
    length: int  # steps
    rate_hz: float
    task: str
    remarks: tuple[str, ...]
    is_verified: bool
    details: Any  # what the format needs to describe the set


class Format(Protocol):
    """A layout of files; its instances go to worker processes."""

    head: str  # of README.md, before the data sheet

    def check(self, contents: Contents) -> None:
        """InputError for contents that the format does not hold, or a library that is missing."""
        ...

    def write(self, folder: Path, place: Place, episode: Episode) -> Any:
        """Store an episode in the set's folder, and return the details that `finish` needs."""
        ...

    def finish(self, folder: Path, name: str, episodes: Sequence[Written], contents: Contents) -> None:
        """Complete the set `name` of these episodes, in their order."""
        ...


def missing(library: str) -> InputError:
    """The error for a library of the extra `export` that is not installed."""
    return InputError(f"export: expected {library}, which is not installed: {INSTALL}")
