"""v_d: limits of the speed in bends and before obstacles."""

from math import inf, sqrt, tan

import numpy as np

from vpf_sim.planning.lane.config import ClearanceConfig, LaneReferenceConfig
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.kinematic_limits import SPEEDS_MPS, KinematicLimits
from vpf_sim.planning.lane.lateral_path import LateralPath
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.speed.creep import Creep
from vpf_sim.planning.lane.speed_config import ApproachConfig, EasingConfig, LookConfig, RestConfig, SpeedConfig
from vpf_sim.types import Bools, Floats

SHORTEST_M = 0.1  # of a stop: the error of a face
STRAIGHT = 0.02  # slope, and share of the tightest bend, of a path that needs no rest
# v_d so far below the speed, or by that share of it but no less, asks the controller for a_0 at most:
EASY_MPS, EASY_SHARE, LEAST_MPS = 2.5, 0.6, 1.0
HARD_MPS, HARD_SHARE, HARD_LEAST_MPS = 3.0, 0.7, 1.2  # and so far for more, as the gains of `robust` have it


class SpeedLimits:
    """The speed reference, with the memory of the last one and of creeping."""

    def __init__(
        self,
        config: LaneReferenceConfig,
        clearance: ClearanceConfig,
        speed_reference_mps: float,
        rate_hz: float,
        kinematics: KinematicLimits,
    ) -> None:
        self._config = config.speed
        self._clearance = clearance
        self._brake_mps2 = config.brake_mps2
        self._closest_m = config.closest_standoff_m
        self._speed_reference_mps = speed_reference_mps
        self._dt_s = 1.0 / rate_hz
        self._kinematics = kinematics
        self._gaps_m = np.array([clearance.least_m, clearance.full_speed_m])
        self._beside_mps = np.array([kinematics.walking_mps, speed_reference_mps])
        self._rate_hz = rate_hz
        self.restart(speed_reference_mps)

    def restart(self, speed_mps: float) -> None:
        """Restart at a speed."""
        self._wanted_mps = speed_mps
        self._creep = Creep(self._config, self._clearance, self._closest_m, self._kinematics, self._rate_hz)

    def update(
        self,
        lane: Lane,
        geometry: ObstacleGeometry,
        minimum_m: float,
        speed_mps: float,
        path: LateralPath | None = None,
    ) -> float:
        """m/s after one step of 1 / rate_hz, where the car follows a path or, without one, goes along the road."""
        config = self._config
        if config is None:
            return self._speed_reference_mps
        wanted = self._speed(config, lane, geometry, minimum_m, speed_mps)
        if path is not None and len(geometry):
            settled = self._settled(config.rest, geometry, minimum_m, path) if config.rest is not None else inf
            unwound = self._unwound(geometry, lane, path) if config.unwind is not None else inf
            wanted = min(wanted, max(min(settled, unwound), _comfortable(config, speed_mps)))
        return self._risen(config, wanted, speed_mps)

    def shut(self, geometry: ObstacleGeometry, minimum_m: float) -> Bools:
        """(K,) before which obstacles the car stops, since at the minimum there is no way past them.

        Until it creeps, it stops before the first of a row that any of it closes.
        """
        least_m = self._clearance.least_m
        if self._creep.walks or (self._config is not None and self._config.row_stop is None):
            closed = geometry.overlap(minimum_m, least_m) > 0.0
            return closed & geometry.stands & (geometry.way_m > 0.0)
        return geometry.shut_rows(minimum_m, least_m, self._clearance.full_speed_m)

    def _risen(self, config: SpeedConfig, wanted_mps: float, speed_mps: float) -> float:
        """v_d, which falls at once and rises gently."""
        if config.rise is None:
            return wanted_mps
        rise = config.rise.acceleration_mps2 * self._dt_s
        self._wanted_mps = min(wanted_mps, max(self._wanted_mps, speed_mps) + rise)
        return self._wanted_mps

    def _speed(
        self, config: SpeedConfig, lane: Lane, geometry: ObstacleGeometry, minimum_m: float, speed_mps: float
    ) -> float:
        """v_d: the reference speed, less in tight bends and before obstacles that cannot be cleared in time."""
        limit, ease = self._speed_reference_mps, _comfortable(config, speed_mps)
        bend = abs(lane.curvature_per_m)
        if config.bends is not None and bend > 0.0:
            limit = min(limit, sqrt(config.bends.acceleration_mps2 / bend))
        if not len(geometry):
            return limit
        way, nearest = geometry.way_m, self._creep.nearest(speed_mps)
        gap = -geometry.overlap(minimum_m, 0.0)
        passed = geometry.obstacles.speed_mps + self._beside(config, gap)
        passing = geometry.stands & (way <= 0.0)
        limit = float(np.maximum(passed, ease).min(where=passing, initial=limit))
        counts = (geometry.present | geometry.moves) & (way > 0.0)
        if not counts.any():
            return limit
        if config.look is not None:
            limit = min(limit, max(self._looking(config.look, config.turn_m, lane, geometry, minimum_m), ease))
        limits = self._before_each(config, lane, geometry, minimum_m, speed_mps, gap, passed)
        creep_mps = 0.0 if config.creep is None else config.creep.speed_mps
        if config.headed_at is not None:
            met = geometry.obstacles.speed_mps + np.maximum(geometry.met(lane) / config.headed_at.time_s, creep_mps)
            limits = np.minimum(limits, np.maximum(met, ease))
        creep = np.where((way > nearest) & ~geometry.moves, creep_mps, 0.0)
        return float(np.maximum(limits, creep).min(where=counts, initial=limit))

    def _before_each(
        self,
        config: SpeedConfig,
        lane: Lane,
        geometry: ObstacleGeometry,
        minimum_m: float,
        speed_mps: float,
        gap_m: Floats,
        passed_mps: Floats,
    ) -> Floats:
        """(K,) m/s before each obstacle: of a stop where it closes the way, else of the shift past it."""
        there, stop = np.full(len(geometry), inf), self._stop(config, lane, geometry)
        if config.approach is not None:
            there = self._before(config.approach, lane, geometry, minimum_m, gap_m)
        there = np.minimum(there, np.maximum(stop, passed_mps))
        closed, shut = gap_m < self._clearance.least_m, self.shut(geometry, minimum_m)
        limits = np.where(closed | shut, stop, there)
        if config.easing is None:
            return limits
        return self._braked(config, config.easing, limits, geometry, speed_mps, closed, shut)

    def _stop(self, config: SpeedConfig, lane: Lane, geometry: ObstacleGeometry) -> Floats:
        """(K,) m/s from which the car stops before each obstacle, or falls in behind a moving one."""
        way, body_mps, follow = geometry.way_m, geometry.obstacles.speed_mps, config.follow
        spare = way - self._creep.standoff(lane, geometry)
        if follow is not None:
            spare = spare - follow.time_gap_s * body_mps
        stop: Floats = np.sqrt(2.0 * self._brake_mps2 * np.maximum(spare, 0.0))
        if follow is None or not geometry.moves.any():
            return stop
        share = np.maximum(1.0 + spare / (config.standoff_m + np.maximum(way, 0.0)), 0.0)
        falls_back = np.where(way > config.near_m, body_mps - follow.fall_back_mps, 0.0)
        return np.maximum(body_mps * np.minimum(share, 1.0), falls_back) + stop

    def _braked(
        self,
        config: SpeedConfig,
        easing: EasingConfig,
        limits_mps: Floats,
        geometry: ObstacleGeometry,
        speed_mps: float,
        closed: Bools,
        shut: Bools,
    ) -> Floats:
        """(K,) m/s, the limits before each obstacle as far as comfort allows.

        The car brakes beyond comfort where it would else hit an obstacle that closes the way, or, before a row that is
        shut, where that leaves the way for a turn.
        """
        closing, way, ease = speed_mps - geometry.obstacles.speed_mps, geometry.way_m, eased(speed_mps)
        decelerations = easing.firm_mps2, self._kinematics.full_brake_mps2
        turns = braked(speed_mps, closing, way, config.turn_m, *decelerations)
        least = np.where(shut & ~closed, ease, braked(speed_mps, closing, way, config.near_m, *decelerations))
        return np.where(shut & (turns > -inf) & (turns < ease), turns, np.maximum(limits_mps, least))

    def _looking(
        self, config: LookConfig, turn_m: float, lane: Lane, geometry: ObstacleGeometry, minimum_m: float
    ) -> float:
        """m/s before a row with a gap that one more obstacle would close: a stop leaves the way for a turn."""
        gap = geometry.gaps(lane, minimum_m, config.beside_m)
        narrow = geometry.beside((gap > 0.0) & (gap < config.gap_m)) & (geometry.way_m > turn_m)
        nearest = float(geometry.way_m.min(where=narrow, initial=inf))
        return sqrt(config.speed_mps**2 + 2.0 * self._brake_mps2 * max(nearest - config.ahead_m, 0.0))

    def _beside(self, config: SpeedConfig, gap_m: Floats) -> Floats:
        """(K,) m/s at which obstacles are passed at that gap; inf where it is as wide as wanted."""
        if config.narrow_gap is None:
            return np.full(len(gap_m), inf)
        speed = np.interp(gap_m, self._gaps_m, self._beside_mps)
        return np.where(gap_m < self._clearance.full_speed_m, speed, np.inf)

    def _before(
        self, config: ApproachConfig, lane: Lane, geometry: ObstacleGeometry, minimum_m: float, gap_m: Floats
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
        goal_m = 0.0 if self._narrow(config, geometry, minimum_m, y) else abs(minimum_m - y)
        there = np.maximum(self._kinematics.speed(way, wanted, goal_m, abs(slope)), self._kinematics.walking_mps)
        return geometry.obstacles.speed_mps + np.where(reached, there, 0.0)

    def _narrow(self, config: ApproachConfig, geometry: ObstacleGeometry, minimum_m: float, y_m: float) -> bool:
        """Whether beyond the minimum there is no room for a car that is still turned while it passes."""
        beyond = minimum_m + float(np.sign(minimum_m - y_m)) * config.turned_m
        covers = geometry.overlap(beyond, self._clearance.full_speed_m) > 0.0
        return bool((covers & geometry.present).any())

    def _settled(self, config: RestConfig, geometry: ObstacleGeometry, minimum_m: float, path: LateralPath) -> float:
        """m/s at which the path comes to rest before it is too near to obstacles beyond the minimum."""
        if max(abs(path.slope), abs(path.bend_per_m) * self._kinematics.radius_m) < STRAIGHT:
            return inf
        if not geometry.stands.any():
            return max(float(SPEEDS_MPS[-1]), self._kinematics.walking_mps)
        way, shift = self._kinematics.at_speeds.rest(path.slope, path.bend_per_m)
        room = -geometry.overlap(minimum_m, 0.0)
        kept = np.minimum(room, self._clearance.full_speed_m)
        side = np.sign(geometry.obstacles.middle_m - minimum_m)
        last = minimum_m + side * (room - kept + config.tolerance_m)  # (K,) place from which there is less than that
        beyond, towards = side[:, None] * (path.y_m + shift - last[:, None]), side[:, None] * shift > 0.0
        reached = geometry.stands[:, None] & towards & (geometry.way_m[:, None] < way)
        worst = beyond.max(axis=0, where=reached, initial=-1.0)
        settled = float(np.interp(0.0, np.maximum.accumulate(worst), SPEEDS_MPS))
        return max(settled, self._kinematics.walking_mps)

    def _unwound(self, geometry: ObstacleGeometry, lane: Lane, path: LateralPath) -> float:
        """m/s at which the wheels are straight before the path is too steep towards what is beside it.

        The slope is largest there, p + b^2 / (2 j), and j falls with the speed (`steering_unwind`).
        """
        if abs(path.bend_per_m) * self._kinematics.radius_m < STRAIGHT:
            return inf
        side = 1.0 if path.bend_per_m > 0.0 else -1.0
        largest = self._kinematics.path_between(geometry.between(lane, path.y_m), path.y_m)[side > 0.0]
        peak = side * path.slope + 0.5 * path.bend_per_m**2 / self._kinematics.at_speeds.steering_per_m2
        unwound = float(np.interp(largest + STRAIGHT, peak, SPEEDS_MPS, right=inf))
        return max(unwound, self._kinematics.walking_mps)


def eased(speed_mps: float) -> float:
    """m/s, the least that is asked of a car at that speed where comfortable braking is enough."""
    return speed_mps - max(min(EASY_MPS, EASY_SHARE * speed_mps), LEAST_MPS)


def _comfortable(config: SpeedConfig, speed_mps: float) -> float:
    """m/s, the least that is asked of a car at that speed; -inf where its comfort does not count."""
    return -inf if config.easing is None else eased(speed_mps)


def braked(
    speed_mps: float, closing_mps: Floats, way_m: Floats, before_m: float, firm_mps2: float, full_mps2: float
) -> Floats:
    """(K,) m/s, the least that is asked before each obstacle: harder braking only as far as a stop needs it.

    The stop ends `before_m` before the face, at the obstacle's speed; -inf where not even the full brake does that.
    """
    needed = np.maximum(closing_mps, 0.0) ** 2 / (2.0 * np.maximum(way_m - before_m, SHORTEST_M))
    hard = (needed - firm_mps2) / (full_mps2 - firm_mps2)
    begins = speed_mps - max(min(HARD_MPS, HARD_SHARE * speed_mps), HARD_LEAST_MPS)
    return np.where(hard > 0.0, np.where(hard < 1.0, begins - hard, -np.inf), eased(speed_mps))
