"""v_d: limits of the speed in bends and before obstacles."""

from math import inf, sqrt, tan

import numpy as np

from vpf_sim.braking import comfortable_speed, hard_excess
from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.kinematic_limits import SPEEDS_MPS, KinematicLimits
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig, LookConfig, SpeedConfig
from vpf_sim.planning.lane.lateral_path import LateralPath
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.speed.creep import Creep
from vpf_sim.types import Bools, Floats

SHORTEST_M = 0.1  # of a stop: the error of a face
STRAIGHT = 0.02  # slope, and share of the tightest bend, of a path that needs no rest


class SpeedLimits:
    """The speed reference, with the memory of the last one and of creeping."""

    def __init__(
        self, config: SpeedConfig, planner: LanePlannerConfig, setup: DriverSetup, kinematics: KinematicLimits
    ) -> None:
        self._config, self._planner, self._setup, self._kinematics = config, planner, setup, kinematics
        self._clearance, self._braking = planner.clearance, planner.braking
        self._walking_mps, self._dt_s = planner.limits.walking_mps, 1.0 / setup.rate_hz
        self._gaps_m = np.array([self._clearance.least_m, self._clearance.full_speed_m])
        self._beside_mps = np.array([self._walking_mps, setup.speed_reference_mps])
        self.restart(setup.speed_reference_mps)

    def restart(self, speed_mps: float) -> None:
        """Restart at a speed."""
        self._wanted_mps, creep = speed_mps, self._config.creep
        self._creep = None if creep is None else Creep(creep.standing_s, self._planner, self._setup)

    def update(
        self,
        lane: Lane,
        geometry: ObstacleGeometry,
        minimum_m: float,
        speed_mps: float,
        path: LateralPath | None = None,
    ) -> float:
        """m/s after one step of 1 / rate_hz, where the car follows a path or, without one, goes along the road.

        It falls at once and rises gently.
        """
        config = self._config
        wanted = self._speed(lane, geometry, minimum_m, speed_mps)
        if path is not None and len(geometry):
            settled = inf if config.rest_m is None else self._settled(config.rest_m, geometry, minimum_m, path)
            straightened = inf if config.unwind is None else self._straightened(geometry, lane, path)
            wanted = min(wanted, max(min(settled, straightened), self._comfortable(speed_mps)))
        rise = self._braking.rise_mps2 * self._dt_s
        self._wanted_mps = min(wanted, max(self._wanted_mps, speed_mps) + rise)
        return self._wanted_mps

    def blocked(self, geometry: ObstacleGeometry, minimum_m: float) -> Bools:
        """(K,) before which obstacles the car stops, since at the minimum there is no way past them.

        Until it creeps, it stops before the first of a row that any of it closes.
        """
        if self._config.row_stop is None or (self._creep is not None and self._creep.is_allowed):
            closed = geometry.overlap(minimum_m, self._clearance.least_m) > 0.0
            return closed & geometry.is_static & (geometry.way_m > 0.0)
        return geometry.blocked_rows(minimum_m)

    def _comfortable(self, speed_mps: float) -> float:
        """m/s, the least that is asked of a car at that speed; -inf where its comfort does not count."""
        return -inf if self._config.firm_mps2 is None else comfortable_speed(speed_mps)

    def _speed(self, lane: Lane, geometry: ObstacleGeometry, minimum_m: float, speed_mps: float) -> float:
        """v_d: the reference speed, less in tight bends and before obstacles that cannot be cleared in time."""
        config, limit, ease = self._config, self._setup.speed_reference_mps, self._comfortable(speed_mps)
        bend = abs(lane.curvature_per_m)
        if config.bend_mps2 is not None and bend > 0.0:
            limit = min(limit, sqrt(config.bend_mps2 / bend))
        if not len(geometry):
            return limit
        way, nearest = geometry.way_m, inf if self._creep is None else self._creep.nearest(speed_mps)
        gap = -geometry.overlap(minimum_m, 0.0)
        passed = geometry.obstacles.speed_mps + self._beside(gap)
        limit = float(np.maximum(passed, ease).min(where=geometry.is_static & (way <= 0.0), initial=limit))
        counts = (geometry.present | geometry.moves) & (way > 0.0)
        if not counts.any():
            return limit
        if config.look is not None:
            limit = min(limit, max(self._looking(config.look, lane, geometry, minimum_m), ease))
        limits = self._before_each(lane, geometry, minimum_m, speed_mps, gap, passed)
        creep_mps = 0.0 if config.creep is None else config.creep.speed_mps
        if config.headed_s is not None:
            met = geometry.obstacles.speed_mps + np.maximum(geometry.met(lane) / config.headed_s, creep_mps)
            limits = np.minimum(limits, np.maximum(met, ease))
        creep = np.where((way > nearest) & ~geometry.moves, creep_mps, 0.0)
        return float(np.maximum(limits, creep).min(where=counts, initial=limit))

    def _before_each(
        self,
        lane: Lane,
        geometry: ObstacleGeometry,
        minimum_m: float,
        speed_mps: float,
        gap_m: Floats,
        passed_mps: Floats,
    ) -> Floats:
        """(K,) m/s before each obstacle: of a stop where it closes the way, else of the shift past it."""
        stop, turned_m = self._stop(lane, geometry), self._config.turned_m
        there = np.maximum(stop, passed_mps)
        if turned_m is not None:
            there = np.minimum(self._before(turned_m, lane, geometry, minimum_m, gap_m), there)
        closed, blocked = gap_m < self._clearance.least_m, self.blocked(geometry, minimum_m)
        limits = np.where(closed | blocked, stop, there)
        if self._config.firm_mps2 is None:
            return limits
        return self._braked(self._config.firm_mps2, limits, geometry, speed_mps, closed, blocked)

    def _stop(self, lane: Lane, geometry: ObstacleGeometry) -> Floats:
        """(K,) m/s from which the car stops before each obstacle, or falls in behind a moving one."""
        way, body_mps, config = geometry.way_m, geometry.obstacles.speed_mps, self._config
        spare = way - self._standoff(lane, geometry) - config.time_gap_s * body_mps
        stop: Floats = np.sqrt(2.0 * self._braking.comfort_mps2 * np.maximum(spare, 0.0))
        if not geometry.moves.any():
            return stop
        share = np.maximum(1.0 + spare / (self._braking.standoff_m + np.maximum(way, 0.0)), 0.0)
        falls_back = np.where(way > config.near_m, body_mps - config.fall_back_mps, 0.0)
        return np.maximum(body_mps * np.minimum(share, 1.0), falls_back) + stop

    def _standoff(self, lane: Lane, geometry: ObstacleGeometry) -> Floats | float:
        """(K,) m from the bumper to each face, kept when stopping: before static ones, a side stays in reach."""
        standoff_m, far_m = self._braking.standoff_m, self._config.far_standoff_m
        if far_m is None or geometry.moves.all():
            return standoff_m
        needed = self._kinematics.least_way(geometry.nearer_side(lane))
        return np.where(geometry.moves, standoff_m, np.minimum(np.maximum(needed, standoff_m), far_m))

    def _braked(
        self,
        firm_mps2: float,
        limits_mps: Floats,
        geometry: ObstacleGeometry,
        speed_mps: float,
        closed: Bools,
        blocked: Bools,
    ) -> Floats:
        """(K,) m/s, the limits before each obstacle as far as comfort allows.

        The car brakes beyond comfort where it would else hit an obstacle that closes the way, or, before a row that is
        blocked, where that leaves room for a turn.
        """
        closing, way, ease = (
            speed_mps - geometry.obstacles.speed_mps,
            geometry.way_m,
            comfortable_speed(speed_mps),
        )
        decelerations = firm_mps2, self._setup.vehicle.full_brake_mps2
        turns = braked(speed_mps, closing, way - self._config.turn_m, *decelerations)
        stops = braked(speed_mps, closing, way - self._config.near_m, *decelerations)
        least = np.where(blocked & ~closed, ease, stops)
        return np.where(blocked & (turns > -inf) & (turns < ease), turns, np.maximum(limits_mps, least))

    def _looking(self, config: LookConfig, lane: Lane, geometry: ObstacleGeometry, minimum_m: float) -> float:
        """m/s before a row with a gap that one more obstacle would close: a stop leaves the way for a turn."""
        gap = geometry.gaps(lane, minimum_m, config.beside_m)
        narrow = geometry.beside((gap > 0.0) & (gap < config.gap_m)) & (geometry.way_m > self._config.turn_m)
        nearest = float(geometry.way_m.min(where=narrow, initial=inf))
        return sqrt(config.speed_mps**2 + 2.0 * self._braking.comfort_mps2 * max(nearest - config.ahead_m, 0.0))

    def _beside(self, gap_m: Floats) -> Floats:
        """(K,) m/s at which obstacles are passed at that gap; inf where it is as wide as wanted."""
        if self._config.narrow_gap is None:
            return np.full(len(gap_m), inf)
        speed = np.interp(gap_m, self._gaps_m, self._beside_mps)
        return np.where(gap_m < self._clearance.full_speed_m, speed, np.inf)

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

    def _settled(self, tolerance_m: float, geometry: ObstacleGeometry, minimum_m: float, path: LateralPath) -> float:
        """m/s at which the path comes to rest before it is too near to obstacles beyond the minimum."""
        if max(abs(path.slope), abs(path.bend_per_m) * self._kinematics.radius_m) < STRAIGHT:
            return inf
        if not geometry.is_static.any():
            return max(float(SPEEDS_MPS[-1]), self._walking_mps)
        way, shift = self._kinematics.at_speeds.rest(path.slope, path.bend_per_m)
        room = -geometry.overlap(minimum_m, 0.0)
        kept = np.minimum(room, self._clearance.full_speed_m)
        side = np.sign(geometry.obstacles.middle_m - minimum_m)
        last = minimum_m + side * (room - kept + tolerance_m)  # (K,) place from which there is less than that
        beyond, towards = side[:, None] * (path.y_m + shift - last[:, None]), side[:, None] * shift > 0.0
        reached = geometry.is_static[:, None] & towards & (geometry.way_m[:, None] < way)
        worst = beyond.max(axis=0, where=reached, initial=-1.0)
        settled = float(np.interp(0.0, np.maximum.accumulate(worst), SPEEDS_MPS))
        return max(settled, self._walking_mps)

    def _straightened(self, geometry: ObstacleGeometry, lane: Lane, path: LateralPath) -> float:
        """m/s at which the wheels are straight before the path is too steep towards what is beside it.

        The slope is largest there, p + b^2 / (2 j), and j falls with the speed (`steering_unwind`).
        """
        if abs(path.bend_per_m) * self._kinematics.radius_m < STRAIGHT:
            return inf
        side = 1.0 if path.bend_per_m > 0.0 else -1.0
        largest = self._kinematics.path_between(geometry.between(lane, path.y_m), path.y_m)[side > 0.0]
        peak = side * path.slope + 0.5 * path.bend_per_m**2 / self._kinematics.at_speeds.steering_per_m2
        straightened = float(np.interp(largest + STRAIGHT, peak, SPEEDS_MPS, right=inf))
        return max(straightened, self._walking_mps)


def braked(speed_mps: float, closing_mps: Floats, way_m: Floats, firm_mps2: float, full_mps2: float) -> Floats:
    """(K,) m/s, the least that is asked for a stop on each way: harder braking only as far as the stop needs it.

    The stop ends at the obstacle's speed; -inf where not even the full brake does that.
    """
    needed = np.maximum(closing_mps, 0.0) ** 2 / (2.0 * np.maximum(way_m, SHORTEST_M))
    hard = (needed - firm_mps2) / (full_mps2 - firm_mps2)
    begins = speed_mps - hard_excess(speed_mps)
    return np.where(hard > 0.0, np.where(hard < 1.0, begins - hard, -np.inf), comfortable_speed(speed_mps))
