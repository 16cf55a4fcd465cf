"""Creeping up to an obstacle that blocks the way, since at standstill a camera sees no flow.

There is no reverse gear, and a shift needs way before the obstacle. So the car stops where the nearer side is still in
reach (`vpf_sim.planning.lane.kinematic_limits`), creeps to the standoff, and only then to the closest standoff.
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
    """How near the car may creep, by how long and how often it has stood."""

    def __init__(
        self,
        config: SpeedConfig | None,
        clearance: ClearanceConfig,
        closest_m: float,
        kinematics: KinematicLimits,
        rate_hz: float,
    ) -> None:
        self._config = config
        self._least_m = clearance.least_m
        self._closest_m = closest_m
        self._kinematics = kinematics
        self._dt_s = 1.0 / rate_hz
        self._stood_s = 0.0
        self._stage = 0

    @property
    def walks(self) -> bool:
        """Whether the car has stood long enough to creep."""
        return self._stage > 0

    def standoff(self, lane: Lane, geometry: ObstacleGeometry) -> Floats:
        """(K,) m from the bumper to each face, kept when stopping."""
        config = self._config
        assert config is not None  # else nothing asks
        if config.far_standoff is None or geometry.moves.all():
            return np.full(len(geometry), config.standoff_m)
        needed = self._kinematics.least_way(geometry.nearer_side(lane, self._least_m))
        kept = np.minimum(np.maximum(needed, config.standoff_m), config.far_standoff.most_m)
        return np.where(geometry.moves, config.standoff_m, kept)

    def nearest(self, speed_mps: float) -> float:
        """m from the bumper to a face, down to which the car may creep after this step; inf where it may not."""
        if self._config is None or self._config.creep is None:
            return np.inf
        self._count(self._config.creep, speed_mps)
        return (np.inf, self._config.standoff_m, self._closest_m)[self._stage]

    def _count(self, config: CreepConfig, speed_mps: float) -> None:
        """Count the time at standstill; motion ends it."""
        if speed_mps > self._kinematics.walking_mps:
            self._stage = 0
        self._stood_s = self._stood_s + self._dt_s if speed_mps < STANDING_MPS else 0.0
        if self._stood_s > config.standing_s:
            self._stage, self._stood_s = min(self._stage + 1, STAGES), 0.0
