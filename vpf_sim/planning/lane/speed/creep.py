"""Walking up to what blocks the way: standing, a camera sees no flow, and what blocks it may not be there, or narrower.

There is no reverse gear, and the way before a body is what getting aside takes. So the car stops where the nearer side
of the body is still in reach (`vpf_sim.planning.lane.kinematic_limits`), walks on to the least distance at which a car
would stop, and only where that has not helped either, as near as there is.
"""

import numpy as np

from vpf_sim.planning.lane.config import ClearanceConfig
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.speed_config import CreepConfig, SpeedConfig
from vpf_sim.types import Floats

STANDING_MPS = 0.1
STAGES = 2  # to the least standoff, and as near as there is


class Creep:
    """How near the car may walk, by how long it has stood and how often."""

    def __init__(
        self,
        config: SpeedConfig | None,
        clearance: ClearanceConfig,
        closest_m: float,
        reach: KinematicLimits,
        rate_hz: float,
    ) -> None:
        self._config = config
        self._least_m = clearance.least_m
        self._closest_m = closest_m
        self._reach = reach
        self._dt_s = 1.0 / rate_hz
        self._stood_s = 0.0
        self._stage = 0

    @property
    def walks(self) -> bool:
        """Whether the car has stood for long enough to walk up to what blocks the way."""
        return self._stage > 0

    def standoff(self, lane: Lane, neighbours: ObstacleGeometry) -> Floats:
        """(K,) m from the bumper to each face, kept when stopping."""
        config = self._config
        assert config is not None  # else nothing asks
        if config.far_standoff is None or neighbours.moves.all():
            return np.full(len(neighbours), config.standoff_m)
        needed = self._reach.least_way(neighbours.nearer_side(lane, self._least_m))
        kept = np.minimum(np.maximum(needed, config.standoff_m), config.far_standoff.most_m)
        return np.where(neighbours.moves, config.standoff_m, kept)

    def nearest(self, speed_mps: float) -> float:
        """m from the bumper to a face, up to which the car may walk after this step; inf where it may not."""
        if self._config is None or self._config.creep is None:
            return np.inf
        self._count(self._config.creep, speed_mps)
        return (np.inf, self._config.standoff_m, self._closest_m)[self._stage]

    def _count(self, config: CreepConfig, speed_mps: float) -> None:
        """A stand ends with the car in motion; the next one begins anew."""
        if speed_mps > self._reach.walking_mps:
            self._stage = 0
        self._stood_s = self._stood_s + self._dt_s if speed_mps < STANDING_MPS else 0.0
        if self._stood_s > config.standing_s:
            self._stage, self._stood_s = min(self._stage + 1, STAGES), 0.0
