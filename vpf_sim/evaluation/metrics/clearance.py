"""How near the other bodies came."""

import numpy as np

from vpf_sim.types import Floats


def min_clearance_m(clearance_m: Floats) -> float | None:
    """Smallest gap between the ego's body and another in the episode, m; None without bodies (where all are inf)."""
    finite = clearance_m[np.isfinite(clearance_m)]
    return float(np.min(finite)) if len(finite) else None


def min_ttc_s(ttc_s: Floats) -> float | None:
    """Smallest time to collision of the episode, s; None where the ego was never on course for a body."""
    return min_clearance_m(ttc_s)
