"""Evidence of one observation for a track: log-odds from its points, one by one.

Two other hypotheses explain the same points. The standing scene differs by its point tracks. The mirror image of what
stands on a wet road differs by its contrast (`moving.mirror`).
"""

import numpy as np

from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import EvidenceConfig
from vpf_sim.perception.quantiles import quantile
from vpf_sim.types import Bools, Floats


def evidence(
    inside: Bools, moving: Floats, standing: Floats, contrast: Floats, faint: float, config: EvidenceConfig
) -> float:
    """Log-odds of an observation of N points, where those `inside` (N,) the track's outline count.

    A point has the chi2 `moving` (N,) as one of the track and `standing` (N,) as one of the standing scene. Its
    `contrast` (N,) speaks against the track below `faint`.
    """
    odds = 0.5 * (np.minimum(standing, config.cap) - np.minimum(moving, config.cap))[inside]
    speaks = odds > config.speaks_for
    number_for, number_against = np.count_nonzero(speaks), np.count_nonzero(odds < -config.speaks_against)
    if number_for <= config.transparency * number_against:
        return config.least
    other = len(odds) - number_for - number_against
    value = config.contrast.weight * (quantile(contrast[inside][speaks], 0.75) - faint)
    value += config.per_for * np.log1p(number_for) - config.per_against * np.log1p(number_against)
    return float(min(max(value - config.per_other * np.log1p(other), config.least), config.most))
