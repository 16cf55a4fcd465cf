"""Quantiles of a few values, equal to those of numpy but without its checks: at least one value, no nan."""

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Floats, Image


def quantile(values: Floats | NDArray[np.float32] | Image, share: float) -> float:
    """The linear quantile of values of any shape: `np.quantile` with the share in float64."""
    ordered = np.sort(values, axis=None)
    place = share * (len(ordered) - 1)
    lower = int(place)
    beyond = place - lower
    before, after = ordered[lower], ordered[min(lower + 1, len(ordered) - 1)]
    gap = float(after - before)
    return float(after) - gap * (1.0 - beyond) if beyond >= 0.5 else float(before) + gap * beyond


def median(values: Floats | NDArray[np.float32]) -> float:
    """The median of values of any shape: `np.median`."""
    flat = values.ravel()
    middle = len(flat) // 2
    if len(flat) % 2:
        return float(np.partition(flat, middle)[middle])
    ordered = np.partition(flat, (middle - 1, middle))
    return 0.5 * float(ordered[middle - 1] + ordered[middle])
