"""Creeping up to an obstacle that blocks the way, since at standstill a camera sees no flow.

There is no reverse gear, and a shift needs way before the obstacle. So the car stops where the nearer side is still in
reach, creeps to the standoff, and only then to the closest standoff.
"""

from math import inf

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig

STANDING_MPS = 0.1
STAGES = 2  # to the standoff, and to the closest one


class Creep:
    """How near the car may creep, by how long and how often it has stood."""

    def __init__(self, standing_s: float, config: LanePlannerConfig, setup: DriverSetup) -> None:
        self._standing_s = standing_s
        self._walking_mps = config.limits.walking_mps
        self._standoffs_m = (inf, config.braking.standoff_m, config.braking.closest_standoff_m)
        self._dt_s = 1.0 / setup.rate_hz
        self._stood_s = 0.0
        self._stage = 0

    @property
    def is_allowed(self) -> bool:
        """Whether the car has stood long enough to creep."""
        return self._stage > 0

    def nearest(self, speed_mps: float) -> float:
        """m from the bumper to a face, down to which the car may creep after this step; inf where it may not."""
        if speed_mps > self._walking_mps:
            self._stage = 0
        self._stood_s = self._stood_s + self._dt_s if speed_mps < STANDING_MPS else 0.0
        if self._stood_s > self._standing_s:
            self._stage, self._stood_s = min(self._stage + 1, STAGES), 0.0
        return self._standoffs_m[self._stage]
