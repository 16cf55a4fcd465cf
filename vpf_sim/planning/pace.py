"""v_d: how fast the robust variant goes by what is ahead: bends, and bodies that are not cleared in time."""

from math import sqrt, tan

import numpy as np

from vpf_sim.planning.lane import Lane, LaneObstacles
from vpf_sim.planning.lane_field import LaneField
from vpf_sim.planning.lane_reference_config import LaneReferenceConfig
from vpf_sim.planning.reach import Reach
from vpf_sim.types import Floats

STANDING_MPS = 0.1


class Pace:
    """The speed reference, with the memory of what was wanted and of how long the car has stood."""

    def __init__(
        self,
        config: LaneReferenceConfig,
        speed_reference_mps: float,
        rate_hz: float,
        reach: Reach,
    ) -> None:
        self._config = config
        self._speed_reference_mps = speed_reference_mps
        self._dt_s = 1.0 / rate_hz
        self._reach = reach
        self._wanted_mps: float | None = None
        self._stood_s = 0.0

    def update(
        self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float, speed_mps: float
    ) -> float:
        """m/s after one step of 1 / rate_hz."""
        if self._config.speed == "constant":
            return self._speed_reference_mps
        return self._risen(self._speed(lane, obstacles, field, minimum_m, speed_mps), speed_mps)

    def _risen(self, wanted_mps: float, speed_mps: float) -> float:
        """v_d, which falls at once and rises gently: what was braked for may be gone from one frame to the next."""
        if self._wanted_mps is not None:
            rise = self._config.rise_mps2 * self._dt_s
            wanted_mps = min(wanted_mps, max(self._wanted_mps, speed_mps) + rise)
        self._wanted_mps = wanted_mps
        return wanted_mps

    def _speed(
        self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float, speed_mps: float
    ) -> float:
        """v_d: the reference speed, less in tight bends and before bodies that cannot be cleared in time."""
        config = self._config
        limit = self._speed_reference_mps
        bend = abs(lane.curvature_per_m)
        if bend > 0.0:
            limit = min(limit, sqrt(config.bend_acceleration_mps2 / bend))
        if not len(obstacles):
            return limit
        way = field.bumper(obstacles)
        moves = obstacles.speed_mps > 0.0
        present = ((field.present(obstacles) > 0.0) | moves) & (way > 0.0)
        clearance = config.minimum_clearance_m if speed_mps > self._reach.walking_mps else config.walking_clearance_m
        blocked = present & (field.overlap(obstacles, minimum_m, clearance) > 0.0)
        spare = way - config.standoff_m - config.time_gap_s * obstacles.speed_mps
        follow = obstacles.speed_mps * np.clip(1.0 + spare / (config.standoff_m + way), 0.0, 1.0)
        stop = follow + np.sqrt(2.0 * config.brake_mps2 * np.maximum(spare, 0.0))
        there = self._before(lane, obstacles, field, minimum_m)
        limits = np.where(blocked, stop, there)
        if self._creeps(speed_mps):
            creep = np.where(way > config.creep_standoff_m, config.creep_mps, 0.0)
            limits = np.where(obstacles.speed_mps > 0.0, limits, np.maximum(limits, creep))
        return float(np.min(limits, where=present, initial=limit))

    def _creeps(self, speed_mps: float) -> bool:
        """Whether the car, having stood for a while, walks up to what blocks it: standing, a camera sees no flow."""
        if speed_mps < STANDING_MPS:
            self._stood_s += self._dt_s
        elif speed_mps > self._reach.walking_mps:
            self._stood_s = 0.0
        return self._stood_s > self._config.standing_s

    def _before(self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float) -> Floats:
        """(K,) m/s before bodies that the minimum avoids, but the car not yet: be there only when the shift is done.

        Where it cannot be done as wide as wanted, walking; where not at all, the car stops, as early as it can.
        """
        config, way, slope = self._config, field.bumper(obstacles), -tan(lane.heading_rad)
        needed = field.shift(obstacles, lane.y_m, minimum_m, config.walking_clearance_m)
        reached = self._reach.reaches(way, needed, slope * float(np.sign(minimum_m - lane.y_m)))
        y, turning = lane.y_m, self._reach.radius_m * abs(slope)
        turned = y + 0.5 * slope * turning
        if (minimum_m - turned) * slope < 0.0:  # even its tightest curve leads past the minimum, or farther from it
            y, way, slope = turned, way - turning, 0.0
        wanted = field.shift(obstacles, y, minimum_m, config.minimum_clearance_m)
        there = np.maximum(self._reach.speed(way, wanted, abs(slope)), self._reach.walking_mps)
        return obstacles.speed_mps + np.where(reached, there, 0.0)
