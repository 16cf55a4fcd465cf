"""Speed limit before tentative obstacles in the way: the car could stop, but does not.

A low obstacle is tentative for one or two metres of way before it is confirmed. Slowing down then costs little, and
saves that way where it is confirmed. Near it, observations decide.
"""

from math import inf

from vpf_sim.planning.lane.config import BrakingConfig
from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.stopping_distance import stopping_speed
from vpf_sim.types import DriverSetup


class TentativeLimit:
    """The speed limit, with the memory of the last one."""

    def __init__(self, clearance_m: float, braking: BrakingConfig, setup: DriverSetup) -> None:
        self._margin_m = 0.5 * setup.vehicle.width_m + clearance_m
        self._bumper_m = 0.5 * setup.vehicle.length_m
        self._braking = braking
        self._dt_s = 1.0 / setup.rate_hz
        self._reference_mps = self._allowed_mps = setup.speed_reference_mps

    def update(
        self, lane: Lane, tentative: LaneObstacles, goal_m: float, speed_mps: float, seen_mps: float = inf
    ) -> float:
        """m/s after one step, where the car goes from `lane.y_m` to `goal_m` across the road.

        At most the reference speed and `seen_mps`. It falls as the car may brake from `speed_mps`, and rises gently.
        """
        braking = self._braking
        way = self._nearest(lane, tentative, goal_m) - self._bumper_m - braking.standoff_m
        stop = stopping_speed(way, braking.emergency_mps2, braking.reaction_s)
        wanted = min(max(stop, braking.cautious_mps), seen_mps)
        least = min(self._allowed_mps, speed_mps) - braking.emergency_mps2 * self._dt_s
        most = self._allowed_mps + braking.rise_mps2 * self._dt_s
        self._allowed_mps = min(max(wanted, least), most, self._reference_mps)
        return self._allowed_mps

    def _nearest(self, lane: Lane, tentative: LaneObstacles, goal_m: float) -> float:
        """m to the first of them in the car's way; inf where there is none."""
        least, most = min(lane.y_m, goal_m) - self._margin_m, max(lane.y_m, goal_m) + self._margin_m
        meets = (tentative.right_m > least) & (tentative.left_m < most) & (tentative.along_m > self._bumper_m)
        return float(tentative.along_m.min(where=meets, initial=inf))
