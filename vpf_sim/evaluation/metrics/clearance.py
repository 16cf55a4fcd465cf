"""Least clearance and time to collision of an episode."""

import numpy as np

from vpf_sim.types import Floats


def min_clearance_m(clearance_m: Floats) -> float | None:
    """Least distance, m, between the ego and another object; None without objects (all inf)."""
    finite = clearance_m[np.isfinite(clearance_m)]
    return float(np.min(finite)) if len(finite) else None


def min_ttc_s(ttc_s: Floats) -> float | None:
    """Least time to collision, s; None where the ego was never on a collision course."""
    return min_clearance_m(ttc_s)
