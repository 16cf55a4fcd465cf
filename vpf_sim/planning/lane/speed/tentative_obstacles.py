"""Speed limit before tentative obstacles in the way: the car could stop, but does not.

A low obstacle is tentative for one or two metres of way before it is confirmed. Slowing down then costs little, and
saves that way where it is confirmed. Near it, observations decide.
"""

from math import inf

from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.speed.clear_distance import safe_speed
from vpf_sim.planning.lane.speed_config import TentativeLimitConfig
from vpf_sim.types import VehicleModel


class TentativeLimit:
    """The speed limit, with the memory of the last one."""

    def __init__(
        self, config: TentativeLimitConfig, vehicle: VehicleModel, speed_reference_mps: float, rate_hz: float
    ) -> None:
        self._config = config
        self._vehicle = vehicle
        self._dt_s = 1.0 / rate_hz
        self._reference_mps = speed_reference_mps
        self._allowed_mps = speed_reference_mps

    def update(
        self, lane: Lane, tentative: LaneObstacles, goal_m: float, speed_mps: float, seen_mps: float = inf
    ) -> float:
        """m/s after one step, where the car goes from `lane.y_m` to `goal_m` across the road.

        At most the reference speed and `seen_mps`. It falls as the car may brake from `speed_mps`, and rises gently.
        """
        config = self._config
        wanted = min(safe_speed(self._nearest(lane, tentative, goal_m), config, self._vehicle), seen_mps)
        least = min(self._allowed_mps, speed_mps) - config.brake_mps2 * self._dt_s
        most = self._allowed_mps + config.rise_mps2 * self._dt_s
        self._allowed_mps = min(max(wanted, least), most, self._reference_mps)
        return self._allowed_mps

    def _nearest(self, lane: Lane, tentative: LaneObstacles, goal_m: float) -> float:
        """m to the first of them in the car's way; inf where there is none."""
        if not len(tentative):
            return inf
        margin = 0.5 * self._vehicle.width_m + self._config.clearance_m
        least, most = min(lane.y_m, goal_m) - margin, max(lane.y_m, goal_m) + margin
        meets = (tentative.right_m > least) & (tentative.left_m < most)
        ahead = tentative.along_m > 0.5 * self._vehicle.length_m
        return float(tentative.along_m.min(where=meets & ahead, initial=inf))
