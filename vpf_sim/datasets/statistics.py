"""Statistics of a data set by which policies normalise: range, mean, deviation, quantiles."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Floats, Image, Integers

QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
LEVELS = 256

Statistics = dict[str, Any]  # name -> nested list


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
