"""Heading and speed reference towards the minimum of the lateral cost.

The minimum jumps when an obstacle appears. The reference follows a path y_r of the rear axle that the car can drive
(`vpf_sim.planning.lane.lateral_path`). The heading is the path's direction, with psi_r the road's,

    psi_d = lag(psi_r + asin(k (y_r - y) / v)) + asin(y_r'),    d psi_d / dt = d lag / dt + v y_r'' / sqrt(1 - y_r'^2).

A bicycle's centre of mass moves at yaw + slip, and d psi / dt = v sin(slip) / l_r, so its yaw is its course through a
lag of l_r / v: l_r / v d psi / dt = chi - psi. The road's direction is known for the centre of mass, so it goes through
that lag and has the slip of a bend (l_r / R). The rear axle has none.
"""

from math import asin, exp, sqrt

import numpy as np

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits, rear_m
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig, PathConfig, WaitConfig
from vpf_sim.planning.lane.lateral_path import LateralPath
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.speed.limits import SpeedLimits
from vpf_sim.planning.stopping_distance import stopping_way
from vpf_sim.types import Reference


class LaneReference:
    """Path across the lane, the heading that follows it, and the speed."""

    def __init__(self, config: LanePlannerConfig, setup: DriverSetup, kinematics: KinematicLimits) -> None:
        self._config, self._clearance, self._vehicle = config, config.clearance, setup.vehicle
        self._dt_s, self._speed_reference_mps = 1.0 / setup.rate_hz, setup.speed_reference_mps
        self._walking_mps, self._kinematics = config.limits.walking_mps, kinematics
        self._speed_limits = SpeedLimits(config.speed, config, setup, kinematics) if config.speed else None
        self.y_m = 0.0  # of the reference, after an update
        self.restart(self._speed_reference_mps)

    def restart(self, speed_mps: float) -> None:
        """Begin anew from where the car is."""
        if self._speed_limits is not None:
            self._speed_limits.restart(speed_mps)
        self._heading_rad: float | None = None
        self._path: LateralPath | None = None

    def update(
        self, lane: Lane, geometry: ObstacleGeometry, minimum_m: float, yaw_rad: float, speed_mps: float
    ) -> Reference:
        """One step of 1 / rate_hz towards the minimum of the lateral cost."""
        wanted = self._speed_reference_mps
        if self._speed_limits is not None:
            wanted = self._speed_limits.update(lane, geometry, minimum_m, speed_mps, self._path)
        config = self._config.path
        if config is None:
            self.y_m = minimum_m
            return Reference(self._straight(lane, minimum_m, yaw_rad, speed_mps), wanted)
        rear = rear_m(lane, self._vehicle)
        if self._path is None:
            self._path = LateralPath(config, self._kinematics, rear, config.shift_s * self._speed_reference_mps)
        between, time_s, side_slopes = lane, np.inf, (np.inf, np.inf)
        if len(geometry):
            between = geometry.between(lane, self._path.y_m)
            side_slopes = geometry.side_slopes(self._path.y_m, self._path.slope)
            time_s = self._time_left(config, geometry, self._path.y_m, speed_mps)
            minimum_m = self._goal(config, self._path, geometry, minimum_m, speed_mps)
        self._path.advance(between, minimum_m, time_s, speed_mps, speed_mps * self._dt_s, side_slopes)
        self._path.hold(rear)
        self.y_m = self._path.y_m
        heading, rate = self._heading(lane, side_slopes, self._path, yaw_rad, speed_mps)
        return Reference(heading, wanted, rate)

    def _time_left(self, config: PathConfig, geometry: ObstacleGeometry, y_m: float, speed_mps: float) -> float:
        """s until the first obstacle is reached that the path would meet where it is."""
        way = geometry.way_m
        hit = (geometry.overlap(y_m, self._clearance.full_speed_m) > 0.0) & (way > 0.0)
        closing = np.maximum(
            max(speed_mps, self._walking_mps) - geometry.obstacles.speed_mps, config.slowest_closing_mps
        )
        return float((way / closing).min(where=hit, initial=np.inf))

    def _goal(
        self, config: PathConfig, path: LateralPath, geometry: ObstacleGeometry, minimum_m: float, speed_mps: float
    ) -> float:
        """The lateral position to which the path leads now, on its way to the minimum."""
        if config.wait is not None and self._waits(config.wait, path, geometry, minimum_m, speed_mps):
            minimum_m = path.y_m
        elif config.hold_m is not None:
            minimum_m = self._held(config.hold_m, path, geometry, minimum_m, speed_mps)
        return geometry.kept_beside(path.y_m, minimum_m)

    def _waits(
        self, config: WaitConfig, path: LateralPath, geometry: ObstacleGeometry, minimum_m: float, speed_mps: float
    ) -> bool:
        """Whether the path can stay longer before the first obstacle for which it must leave its place.

        From nearer the side of an obstacle is known better. The way back does not wait, nor does a path without room
        to spare beside obstacles, nor one behind a moving obstacle.
        """
        if abs(path.slope) > config.slope or abs(minimum_m) < abs(path.y_m):
            return False
        hit = geometry.hinders(path.y_m)
        if not hit.any() or (hit & geometry.moves).any():
            return False
        narrow = geometry.overlap(minimum_m, self._clearance.full_speed_m) > 0.0
        if (narrow & geometry.present).any():
            return False
        needed = float(self._kinematics.limits(speed_mps).way(abs(minimum_m - path.y_m)))
        needed += config.reaction_s * max(speed_mps, self._walking_mps)
        return float(geometry.way_m[hit].min()) > needed

    def _held(
        self, hold_m: float, path: LateralPath, geometry: ObstacleGeometry, minimum_m: float, speed_mps: float
    ) -> float:
        """Where the path leads: to the minimum, or to its own rest where no gap is free at the minimum.

        A car that has turned to a gap that closes has no way left for another one. It holds only where it can still
        stop, and goes back to its own lane all the same.
        """
        way, limits, braking = geometry.way_m, self._speed_limits, self._config.braking
        blocked = geometry.blocked_rows(minimum_m) if limits is None else limits.blocked(geometry, minimum_m)
        if not blocked.any():
            return minimum_m
        _, shift = self._kinematics.limits(np.array([speed_mps])).rest(path.slope, path.bend_per_m)
        rest_m = path.y_m + float(shift[0])
        hit = geometry.is_static & (way > 0.0) & (geometry.overlap(rest_m, self._clearance.least_m) > 0.0)
        if abs(minimum_m) < abs(rest_m) or not hit.any():
            return minimum_m
        first_m, blocked_m = float(way[hit].min()), float(way[blocked].min())
        stops = float(stopping_way(speed_mps, braking.comfort_mps2)) + braking.closest_standoff_m < first_m
        in_row = blocked_m < first_m + self._config.obstacles.row_depth_m
        return rest_m if stops and in_row and min(first_m, blocked_m) < hold_m else minimum_m

    def _straight(self, lane: Lane, minimum_m: float, yaw_rad: float, speed_mps: float) -> float:
        """psi_d rad towards the minimum, without a path."""
        left, right = self._kinematics.between(lane, speed_mps)
        ratio = min(max(self._pull(minimum_m - lane.y_m, speed_mps), -left), right)
        return wrap_angle(yaw_rad + lane.heading_rad + asin(ratio))

    def _pull(self, error_m: float, speed_mps: float) -> float:
        """k (y_r - y) / v."""
        config = self._config.correction
        pull = min(config.per_s, config.per_m * speed_mps) * error_m
        most = min(config.speed_mps, self._config.limits.ratio * speed_mps)
        return min(max(pull, -most), most) / max(speed_mps, 1.0)

    def _heading(
        self, lane: Lane, side_slopes: tuple[float, float], path: LateralPath, yaw_rad: float, speed_mps: float
    ) -> tuple[float, float]:
        """psi_d rad and its rate rad/s."""
        left, right = self._kinematics.between(lane, speed_mps)
        left, right = max(left, -side_slopes[1]), max(right, -side_slopes[0])
        pull = self._pull(path.y_m - rear_m(lane, self._vehicle), speed_mps)
        ratio = min(max(pull, -left - path.slope), right - path.slope)
        course = yaw_rad + lane.heading_rad + asin(min(max(ratio, -1.0), 1.0))
        if self._heading_rad is None:
            self._heading_rad = yaw_rad
        share = 1.0 - exp(-speed_mps * self._dt_s / self._vehicle.l_r_m)
        ahead = wrap_angle(course - self._heading_rad)
        self._heading_rad = wrap_angle(self._heading_rad + share * ahead)
        bend = (1.0 - share) * ahead / self._vehicle.l_r_m + path.bend_per_m / sqrt(1.0 - path.slope**2)
        return wrap_angle(self._heading_rad + asin(path.slope)), speed_mps * bend
