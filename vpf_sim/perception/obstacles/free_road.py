"""Obstacles that are none: the road is visible in their place, over several observations, nearer and nearer.

The foot and outline of an obstacle differ from the road by several times the noise in nearly all observations; bare
road differs less in every other one. A few observations of bare road, less those of anything else, tell the two apart
(Wald, Sequential Analysis, 1947, with steps of one).
"""

import numpy as np

from vpf_sim.geometry import distance_m
from vpf_sim.perception.obstacles.config import FreeRoadConfig
from vpf_sim.types import Floats, Integers


class FreeRoadEvidence:
    """Counts observations of bare road in the place of each obstacle."""

    def __init__(self, config: FreeRoadConfig) -> None:
        self._config = config
        self._score: dict[int, int] = {}
        self._place_m: Floats = np.full(2, np.inf)  # of the car at the last observation

    def record(self, identity: Integers, difference: Floats, place_m: Floats) -> list[int]:
        """Which obstacles (N,) are free road after one more observation, by the image differences (N,); nan: unknown.

        The car is at `place_m` (2,). Parts of an obstacle have one identity and count together.
        """
        config, before, free = self._config, self._score, []
        if distance_m(place_m, self._place_m) < config.travel_m:
            return []
        self._place_m, self._score = place_m.copy(), {}
        for one in np.unique(identity).tolist():
            parts = np.flatnonzero(identity == one)
            value = float(np.fmax.reduce(difference[parts]))
            score = max(before.get(one, 0) + (value < config.road) - (value > config.obstacle), 0)
            if score >= config.observations:
                free += parts.tolist()
                score = 0
            self._score[one] = score
        return free
