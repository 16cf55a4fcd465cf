"""Bodies told by mistake: the road is seen where one should stand, over several looks, nearer and nearer.

What stands on the road differs from it at its foot and outline in all looks but few, by several times the noise; bare
road differs so little in every other look. So a few looks that show bare road, against those that show anything else,
tell the two apart (Wald, Sequential Analysis, 1947, with steps of one).
"""

import numpy as np

from vpf_sim.geometry import distance_m
from vpf_sim.perception.obstacles.config import FreeRoadConfig
from vpf_sim.perception.obstacles.point_hypotheses import Integers
from vpf_sim.types import Floats


class FreeRoadEvidence:
    """Counts the looks at each body that is told."""

    def __init__(self, config: FreeRoadConfig) -> None:
        self._config = config
        self._score: dict[int, int] = {}
        self._place_m: Floats = np.full(2, np.inf)  # of the car at the last look

    def record(self, identity: Integers, difference: Floats, place_m: Floats) -> list[int]:
        """Which of the bodies (N,) a look clears that saw such differences (N,), nan where it saw too little.

        The car is at `place_m` (2,). Parts of a body that fell apart have one identity, and are looked at as one.
        """
        config, before, cleared = self._config, self._score, []
        if distance_m(place_m, self._place_m) < config.way_m:
            return []
        self._place_m, self._score = place_m.copy(), {}
        for one in np.unique(identity).tolist():
            parts = np.flatnonzero(identity == one)
            value = float(np.fmax.reduce(difference[parts]))
            score = max(before.get(one, 0) + (value < config.road) - (value > config.body), 0)
            if score >= config.looks:
                cleared += parts.tolist()
                score = 0
            self._score[one] = score
        return cleared
