"""Quantiles of a few values, at least one and none of them nan, as numpy tells them whose checks take longer."""

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Floats, Image


def quantile(values: Floats | NDArray[np.float32] | Image, share: float) -> float:
    """Up to which this share of the values, of any shape, lies: `np.quantile` with the share in float64, linear."""
    ordered = np.sort(values, axis=None)
    place = share * (len(ordered) - 1)
    lower = int(place)
    beyond = place - lower
    before, after = ordered[lower], ordered[min(lower + 1, len(ordered) - 1)]
    gap = float(after - before)
    return float(after) - gap * (1.0 - beyond) if beyond >= 0.5 else float(before) + gap * beyond


def median(values: Floats | NDArray[np.float32]) -> float:
    """The middle of the values, of any shape, or between the middle two: `np.median`."""
    flat = values.ravel()
    middle = len(flat) // 2
    if len(flat) % 2:
        return float(np.partition(flat, middle)[middle])
    ordered = np.partition(flat, (middle - 1, middle))
    return 0.5 * float(ordered[middle - 1] + ordered[middle])
