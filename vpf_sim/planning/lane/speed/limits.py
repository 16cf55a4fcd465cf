"""v_d: limits of the speed in bends and before obstacles."""

from math import inf, sqrt, tan

import numpy as np

from vpf_sim.braking import comfortable_speed, hard_excess
from vpf_sim.planning.lane.config import LanePlannerConfig, LookConfig, SpeedConfig
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.types import Bools, DriverSetup, Floats

SHORTEST_M = 0.1  # of a stop: the error of a face


class SpeedLimits:
    """The speed reference, with the memory of the last one."""

    def __init__(
        self, config: SpeedConfig, planner: LanePlannerConfig, setup: DriverSetup, kinematics: KinematicLimits
    ) -> None:
        self._config, self._setup, self._kinematics = config, setup, kinematics
        self._clearance, self._braking = planner.clearance, planner.braking
        self._walking_mps, self._dt_s = planner.limits.walking_mps, 1.0 / setup.rate_hz
        self.restart(setup.speed_reference_mps)

    def restart(self, speed_mps: float) -> None:
        """Restart at a speed."""
        self._wanted_mps = speed_mps

    def update(self, lane: Lane, geometry: ObstacleGeometry, minimum_m: float, speed_mps: float) -> float:
        """m/s after one step of 1 / rate_hz; it falls at once and rises gently."""
        wanted = self._speed(lane, geometry, minimum_m, speed_mps)
        rise = self._braking.rise_mps2 * self._dt_s
        self._wanted_mps = min(wanted, max(self._wanted_mps, speed_mps) + rise)
        return self._wanted_mps

    def _speed(self, lane: Lane, geometry: ObstacleGeometry, minimum_m: float, speed_mps: float) -> float:
        """v_d: the reference speed, less in tight bends and before obstacles that cannot be cleared in time."""
        config, limit = self._config, self._setup.speed_reference_mps
        bend = abs(lane.curvature_per_m)
        if config.bend_mps2 is not None and bend > 0.0:
            limit = min(limit, sqrt(config.bend_mps2 / bend))
        if not len(geometry):
            return limit
        counts = (geometry.present | geometry.moves) & (geometry.way_m > 0.0)
        if not counts.any():
            return limit
        if config.look is not None:
            slower = self._looking(config.look, lane, geometry, minimum_m)
            limit = min(limit, max(slower, -inf if config.firm_mps2 is None else comfortable_speed(speed_mps)))
        limits = self._before_each(lane, geometry, minimum_m, speed_mps, -geometry.overlap(minimum_m, 0.0))
        return float(np.maximum(limits, 0.0).min(where=counts, initial=limit))

    def _before_each(
        self,
        lane: Lane,
        geometry: ObstacleGeometry,
        minimum_m: float,
        speed_mps: float,
        gap_m: Floats,
    ) -> Floats:
        """(K,) m/s before each obstacle: of a stop where it closes the way, else of the shift past it."""
        stop, turned_m = self._stop(geometry), self._config.turned_m
        there: Floats = np.full(len(geometry), inf)
        if turned_m is not None:
            there = self._before(turned_m, lane, geometry, minimum_m, gap_m)
        closed = gap_m < self._clearance.least_m
        limits = np.where(closed, stop, there)
        if self._config.firm_mps2 is None:
            return limits
        return self._braked(self._config.firm_mps2, limits, geometry, speed_mps, closed & geometry.stands)

    def _stop(self, geometry: ObstacleGeometry) -> Floats:
        """(K,) m/s from which the car stops before each obstacle, or falls in behind a moving one."""
        way, body_mps, config = geometry.way_m, geometry.obstacles.speed_mps, self._config
        spare = way - self._braking.standoff_m - config.time_gap_s * body_mps
        stop: Floats = np.sqrt(2.0 * self._braking.comfort_mps2 * np.maximum(spare, 0.0))
        if not geometry.moves.any():
            return stop
        share = np.maximum(1.0 + spare / (self._braking.standoff_m + np.maximum(way, 0.0)), 0.0)
        falls_back = np.where(way > config.near_m, body_mps - config.fall_back_mps, 0.0)
        return np.maximum(body_mps * np.minimum(share, 1.0), falls_back) + stop

    def _braked(
        self,
        firm_mps2: float,
        limits_mps: Floats,
        geometry: ObstacleGeometry,
        speed_mps: float,
        shut: Bools,
    ) -> Floats:
        """(K,) m/s, the limits before each obstacle as far as comfort allows.

        The car brakes beyond comfort where it would else hit an obstacle, or, before a static one that closes the way,
        where that leaves the way for a turn.
        """
        closing, way, ease = (
            speed_mps - geometry.obstacles.speed_mps,
            geometry.way_m,
            comfortable_speed(speed_mps),
        )
        decelerations = firm_mps2, self._setup.vehicle.full_brake_mps2
        turns = braked(speed_mps, closing, way - self._config.turn_m, *decelerations)
        stops = braked(speed_mps, closing, way - self._config.near_m, *decelerations)
        return np.where(shut & (turns > -inf) & (turns < ease), turns, np.maximum(limits_mps, stops))

    def _looking(self, config: LookConfig, lane: Lane, geometry: ObstacleGeometry, minimum_m: float) -> float:
        """m/s before a row with a gap that one more obstacle would close: a stop leaves the way for a turn."""
        gap = geometry.gaps(lane, minimum_m, config.beside_m)
        narrow = geometry.beside((gap > 0.0) & (gap < config.gap_m)) & (geometry.way_m > self._config.turn_m)
        nearest = float(geometry.way_m.min(where=narrow, initial=inf))
        return sqrt(config.speed_mps**2 + 2.0 * self._braking.comfort_mps2 * max(nearest - config.ahead_m, 0.0))

    def _before(
        self, turned_m: float, lane: Lane, geometry: ObstacleGeometry, minimum_m: float, gap_m: Floats
    ) -> Floats:
        """(K,) m/s before obstacles that the car can pass at the minimum by `gap_m` (K,), but not yet.

        It gets there only when the shift is done. Where it cannot be done as wide as wanted, at walking speed; where
        not at all, the car stops as early as it can.
        """
        way, slope = geometry.way_m, -tan(lane.heading_rad)
        needed = geometry.shift(lane.y_m, minimum_m, self._clearance.least_m)
        reached = self._kinematics.reaches(way, needed, slope * float(np.sign(minimum_m - lane.y_m)))
        y, turning = lane.y_m, self._kinematics.radius_m * abs(slope)
        turned = y + 0.5 * slope * turning
        if (minimum_m - turned) * slope < 0.0:  # even its tightest curve leads past the minimum, or farther from it
            y, way, slope = turned, way - turning, 0.0
        room = gap_m - 1e-6  # no more can be wanted
        wanted = geometry.shift(y, minimum_m, np.minimum(self._clearance.full_speed_m, room))
        # Beyond the minimum there may be no room for a car that is still turned while it passes.
        beyond = geometry.overlap(minimum_m + float(np.sign(minimum_m - y)) * turned_m, self._clearance.full_speed_m)
        goal_m = 0.0 if ((beyond > 0.0) & geometry.present).any() else abs(minimum_m - y)
        there = np.maximum(self._kinematics.speed(way, wanted, goal_m, abs(slope)), self._walking_mps)
        return geometry.obstacles.speed_mps + np.where(reached, there, 0.0)


def braked(speed_mps: float, closing_mps: Floats, way_m: Floats, firm_mps2: float, full_mps2: float) -> Floats:
    """(K,) m/s, the least that is asked for a stop on each way: harder braking only as far as the stop needs it.

    The stop ends at the obstacle's speed; -inf where not even the full brake does that.
    """
    needed = np.maximum(closing_mps, 0.0) ** 2 / (2.0 * np.maximum(way_m, SHORTEST_M))
    hard = (needed - firm_mps2) / (full_mps2 - firm_mps2)
    begins = speed_mps - hard_excess(speed_mps)
    return np.where(hard > 0.0, np.where(hard < 1.0, begins - hard, -np.inf), comfortable_speed(speed_mps))
