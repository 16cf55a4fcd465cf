"""The data sheet of an exported set, after Gebru et al., "Datasheets for Datasets", CACM 64(12), 2021, in short."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from numpy.typing import NDArray

from vpf_sim import __version__
from vpf_sim.datasets.formats import Written
from vpf_sim.datasets.played_episode import Contents
from vpf_sim.evaluation.sweeps.fingerprint import commit_of
from vpf_sim.reporting.main_table import shown
from vpf_sim.reporting.run_data import StoredRun
from vpf_sim.types import Floats, Image, Integers

MOST_LISTED = 20
TRUTHS = {
    "depth": "m along the optical axis, inf in the sky",
    "flow": "px from the frame before, x right, y down",
    "foe": "px, the image of the direction of motion, nan at standstill",
    "ttc": "s until contact, inf if the gap does not close",
    "instance": "0 ground and sky, -1 scenery, from 1 on an object",
    "hidden": "whether water or a wiper hides the pixel",
}
QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
LEVELS = 256

Statistics = dict[str, object]  # name -> nested list


def make(
    head: str,
    run: StoredRun,
    format_name: str,
    contents: Contents,
    episodes: Sequence[Written],
    left_out: Mapping[str, str],
    remarks: Sequence[str],
) -> str:
    """The sheet as Markdown, after the format's own head."""
    made = run.manifest.fingerprint
    environment = Environment(
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        loader=PackageLoader("vpf_sim.datasets", ""),
    )
    return environment.get_template("datasheet.md.jinja").render(
        head=head,
        run=run,
        made={"vpf_sim": made.get("vpf_sim"), "source": made.get("source")},
        commit=commit_of(made.get("source", "")),
        version=__version__,
        format_name=format_name,
        contents=contents,
        truths={name: TRUTHS[name] for name in contents.truth},
        episodes=episodes,
        frames=sum(one.length for one in episodes),
        rate_hz=episodes[0].rate_hz,
        drivers=", ".join(dict.fromkeys(f"`{one.record.driver}`" for one in episodes)),
        tasks=dict.fromkeys(one.task for one in episodes),
        cells=_cells(episodes),
        left_out=[*left_out.items()],
        verified=sum(one.is_verified for one in episodes),
        without_hash=sum(one.record.frames_sha256 is None for one in episodes),
        remarks=remarks,
        most=MOST_LISTED,
    )


def _cells(episodes: Sequence[Written]) -> Iterator[list[str]]:
    """A row for each scenario, weather and driver."""
    cells: dict[tuple[str, ...], list[Written]] = defaultdict(list)
    for one in episodes:
        cells[one.record.cell].append(one)
    for (scenario, weather, driver), some in cells.items():
        endings = Counter(one.record.status for one in some)
        ended = ", ".join(f"{count} {name}" for name, count in endings.most_common())
        frames = sum(one.length for one in some)
        row = (shown(scenario), shown(weather), driver, spans(one.record.seed for one in some))
        yield [str(value).replace("|", "\\|") for value in (*row, len(some), frames, ended)]


def spans(numbers: Iterable[int]) -> str:
    """Numbers as spans: "0 to 2, 5"."""
    found: list[list[int]] = []
    for number in sorted(set(numbers)):
        if found and number == found[-1][1] + 1:
            found[-1][1] = number
        else:
            found.append([number, number])
    return ", ".join(f"{first} to {last}" if last > first else str(first) for first, last in found)


def of_values(values: NDArray[Any]) -> Statistics:
    """The statistics of (n, k) or (n,) numbers, each a list of k."""
    rows = np.asarray(values, float).reshape(len(values), -1)
    found = {"min": rows.min(0), "max": rows.max(0), "mean": rows.mean(0), "std": rows.std(0)}
    found |= dict(zip(QUANTILES, np.quantile(rows, [*QUANTILES.values()], axis=0), strict=True))
    return {**{name: value.tolist() for name, value in found.items()}, "count": [len(rows)]}


class PixelCounts:
    """How often each level occurs in the channels of some pictures."""

    def __init__(self, channels: int = 3) -> None:
        self.counts: Integers = np.zeros((channels, LEVELS), np.int64)
        self.pictures = 0

    def add(self, picture: Image) -> None:
        """Count the levels of an (H, W, C) picture."""
        self.pictures += 1
        for channel, row in enumerate(self.counts):
            row += np.bincount(picture[..., channel].ravel(), minlength=LEVELS)

    def statistics(self) -> Statistics:
        """The statistics of the channels in [0, 1], each as (C, 1, 1); `count` is that of pictures."""
        levels = np.arange(LEVELS) / (LEVELS - 1.0)
        found = [_of_counts(levels, row) for row in self.counts]
        columns = {name: [[[one[name]]] for one in found] for name in found[0]}
        return {**columns, "count": [self.pictures]}


def combined(several: Sequence[PixelCounts]) -> PixelCounts:
    """The counts of all pictures together."""
    result = PixelCounts(len(several[0].counts))
    result.counts = np.sum([one.counts for one in several], axis=0)
    result.pictures = sum(one.pictures for one in several)
    return result


def _of_counts(levels: Floats, counts: Integers) -> dict[str, float]:
    """The statistics of numbers of which each level occurs so many times."""
    present = levels[counts > 0]
    mean = np.average(levels, weights=counts)
    std = np.sqrt(np.average((levels - mean) ** 2, weights=counts))
    below = np.cumsum(counts) / counts.sum()
    quantiles = {name: levels[np.searchsorted(below, share)] for name, share in QUANTILES.items()}
    found = {"min": present[0], "max": present[-1], "mean": mean, "std": std, **quantiles}
    return {name: float(value) for name, value in found.items()}
