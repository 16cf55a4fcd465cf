"""v_d: how fast the robust variant goes by what is ahead: bends, and bodies that are not cleared in time."""

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

SHORTEST_M = 0.1  # of a stop: a face is told no better
STRAIGHT = 0.02  # slope, and share of the tightest bend, of a path that needs no rest
# v_d so far below the speed, or by that share of it but no less, asks the controller for a_0 at most:
EASY_MPS, EASY_SHARE, LEAST_MPS = 2.5, 0.6, 1.0
HARD_MPS, HARD_SHARE, HARD_LEAST_MPS = 3.0, 0.7, 1.2  # and so far for more, as the gains of `robust` have it


class SpeedLimits:
    """The speed reference, with the memory of what was wanted and of how near the car may creep."""

    def __init__(
        self,
        config: LaneReferenceConfig,
        clearance: ClearanceConfig,
        speed_reference_mps: float,
        rate_hz: float,
        reach: KinematicLimits,
    ) -> None:
        self._config = config.speed
        self._clearance = clearance
        self._brake_mps2 = config.brake_mps2
        self._closest_m = config.closest_standoff_m
        self._speed_reference_mps = speed_reference_mps
        self._dt_s = 1.0 / rate_hz
        self._reach = reach
        self._gaps_m = np.array([clearance.least_m, clearance.full_speed_m])
        self._beside_mps = np.array([reach.walking_mps, speed_reference_mps])
        self._rate_hz = rate_hz
        self.restart(speed_reference_mps)

    def restart(self, speed_mps: float) -> None:
        """Begin anew at a speed."""
        self._wanted_mps = speed_mps
        self._creep = Creep(self._config, self._clearance, self._closest_m, self._reach, self._rate_hz)

    def update(
        self,
        lane: Lane,
        neighbours: ObstacleGeometry,
        minimum_m: float,
        speed_mps: float,
        glide: LateralPath | None = None,
    ) -> float:
        """m/s after one step of 1 / rate_hz, where the car follows a path or, without one, goes along the road."""
        config = self._config
        if config is None:
            return self._speed_reference_mps
        wanted = self._speed(config, lane, neighbours, minimum_m, speed_mps)
        if glide is not None and len(neighbours):
            settled = self._settled(config.rest, neighbours, minimum_m, glide) if config.rest is not None else inf
            unwound = self._unwound(neighbours, lane, glide) if config.unwind is not None else inf
            wanted = min(wanted, max(min(settled, unwound), _comfortable(config, speed_mps)))
        return self._risen(config, wanted, speed_mps)

    def shut(self, neighbours: ObstacleGeometry, minimum_m: float) -> Bools:
        """(K,) before which bodies the car is to stop, since at the minimum there is no way past them.

        As long as it has not walked up to what blocks the way, it stops before the first of a row that any of it shuts.
        """
        least_m = self._clearance.least_m
        if self._creep.walks or (self._config is not None and self._config.row_stop is None):
            closed = neighbours.overlap(minimum_m, least_m) > 0.0
            return closed & neighbours.stands & (neighbours.way_m > 0.0)
        return neighbours.shut_rows(minimum_m, least_m, self._clearance.full_speed_m)

    def _risen(self, config: SpeedConfig, wanted_mps: float, speed_mps: float) -> float:
        """v_d, which falls at once and rises gently: what was braked for may be gone from one frame to the next."""
        if config.rise is None:
            return wanted_mps
        rise = config.rise.acceleration_mps2 * self._dt_s
        self._wanted_mps = min(wanted_mps, max(self._wanted_mps, speed_mps) + rise)
        return self._wanted_mps

    def _speed(
        self, config: SpeedConfig, lane: Lane, neighbours: ObstacleGeometry, minimum_m: float, speed_mps: float
    ) -> float:
        """v_d: the reference speed, less in tight bends and before obstacles that cannot be cleared in time."""
        limit, ease = self._speed_reference_mps, _comfortable(config, speed_mps)
        bend = abs(lane.curvature_per_m)
        if config.bends is not None and bend > 0.0:
            limit = min(limit, sqrt(config.bends.acceleration_mps2 / bend))
        if not len(neighbours):
            return limit
        way, nearest = neighbours.way_m, self._creep.nearest(speed_mps)
        gap = -neighbours.overlap(minimum_m, 0.0)
        passed = neighbours.bodies.speed_mps + self._beside(config, gap)
        passing = neighbours.stands & (way <= 0.0)
        limit = float(np.maximum(passed, ease).min(where=passing, initial=limit))
        counts = (neighbours.present | neighbours.moves) & (way > 0.0)
        if not counts.any():
            return limit
        if config.look is not None:
            limit = min(limit, max(self._looking(config.look, config.turn_m, lane, neighbours, minimum_m), ease))
        limits = self._before_each(config, lane, neighbours, minimum_m, speed_mps, gap, passed)
        creep_mps = 0.0 if config.creep is None else config.creep.speed_mps
        if config.headed_at is not None:
            met = neighbours.bodies.speed_mps + np.maximum(neighbours.met(lane) / config.headed_at.time_s, creep_mps)
            limits = np.minimum(limits, np.maximum(met, ease))
        creep = np.where((way > nearest) & ~neighbours.moves, creep_mps, 0.0)
        return float(np.maximum(limits, creep).min(where=counts, initial=limit))

    def _before_each(
        self,
        config: SpeedConfig,
        lane: Lane,
        neighbours: ObstacleGeometry,
        minimum_m: float,
        speed_mps: float,
        gap_m: Floats,
        passed_mps: Floats,
    ) -> Floats:
        """(K,) m/s before each obstacle: of a stop where it closes the way, else of the shift past it."""
        there, stop = np.full(len(neighbours), inf), self._stop(config, lane, neighbours)
        if config.approach is not None:
            there = self._before(config.approach, lane, neighbours, minimum_m, gap_m)
        there = np.minimum(there, np.maximum(stop, passed_mps))
        closed, shut = gap_m < self._clearance.least_m, self.shut(neighbours, minimum_m)
        limits = np.where(closed | shut, stop, there)
        if config.easing is None:
            return limits
        return self._braked(config, config.easing, limits, neighbours, speed_mps, closed, shut)

    def _stop(self, config: SpeedConfig, lane: Lane, neighbours: ObstacleGeometry) -> Floats:
        """(K,) m/s from which the car stops before each obstacle, or falls in behind a moving one."""
        way, body_mps, follow = neighbours.way_m, neighbours.bodies.speed_mps, config.follow
        spare = way - self._creep.standoff(lane, neighbours)
        if follow is not None:
            spare = spare - follow.time_gap_s * body_mps
        stop: Floats = np.sqrt(2.0 * self._brake_mps2 * np.maximum(spare, 0.0))
        if follow is None or not neighbours.moves.any():
            return stop
        share = np.maximum(1.0 + spare / (config.standoff_m + np.maximum(way, 0.0)), 0.0)
        falls_back = np.where(way > config.near_m, body_mps - follow.fall_back_mps, 0.0)
        return np.maximum(body_mps * np.minimum(share, 1.0), falls_back) + stop

    def _braked(
        self,
        config: SpeedConfig,
        easing: EasingConfig,
        limits_mps: Floats,
        neighbours: ObstacleGeometry,
        speed_mps: float,
        closed: Bools,
        shut: Bools,
    ) -> Floats:
        """(K,) m/s, the limits before each obstacle as far as comfort allows.

        The car brakes beyond comfort where it would else hit an obstacle that closes the way, or, before a row that is
        shut, where that leaves the way for a turn.
        """
        closing, way, ease = speed_mps - neighbours.bodies.speed_mps, neighbours.way_m, eased(speed_mps)
        decelerations = easing.firm_mps2, self._reach.full_brake_mps2
        turns = braked(speed_mps, closing, way, config.turn_m, *decelerations)
        least = np.where(shut & ~closed, ease, braked(speed_mps, closing, way, config.near_m, *decelerations))
        return np.where(shut & (turns > -inf) & (turns < ease), turns, np.maximum(limits_mps, least))

    def _looking(
        self, config: LookConfig, turn_m: float, lane: Lane, neighbours: ObstacleGeometry, minimum_m: float
    ) -> float:
        """m/s before a row with a gap that one more obstacle would close: a stop leaves the way for a turn."""
        gap = neighbours.gaps(lane, minimum_m, config.beside_m)
        narrow = neighbours.beside((gap > 0.0) & (gap < config.gap_m)) & (neighbours.way_m > turn_m)
        nearest = float(neighbours.way_m.min(where=narrow, initial=inf))
        return sqrt(config.speed_mps**2 + 2.0 * self._brake_mps2 * max(nearest - config.ahead_m, 0.0))

    def _beside(self, config: SpeedConfig, gap_m: Floats) -> Floats:
        """(K,) m/s at which obstacles are passed at that gap; inf where it is as wide as wanted."""
        if config.narrow_gap is None:
            return np.full(len(gap_m), inf)
        speed = np.interp(gap_m, self._gaps_m, self._beside_mps)
        return np.where(gap_m < self._clearance.full_speed_m, speed, np.inf)

    def _before(
        self, config: ApproachConfig, lane: Lane, neighbours: ObstacleGeometry, minimum_m: float, gap_m: Floats
    ) -> Floats:
        """(K,) m/s before bodies that the minimum avoids, by `gap_m` (K,), but the car not yet.

        It shall be there only when as much of the shift is done as they need. Where it cannot be done as wide as
        wanted, walking; where not at all, the car stops, as early as it can.
        """
        way, slope = neighbours.way_m, -tan(lane.heading_rad)
        needed = neighbours.shift(lane.y_m, minimum_m, self._clearance.least_m)
        reached = self._reach.reaches(way, needed, slope * float(np.sign(minimum_m - lane.y_m)))
        y, turning = lane.y_m, self._reach.radius_m * abs(slope)
        turned = y + 0.5 * slope * turning
        if (minimum_m - turned) * slope < 0.0:  # even its tightest curve leads past the minimum, or farther from it
            y, way, slope = turned, way - turning, 0.0
        room = gap_m - 1e-6  # no more can be wanted
        wanted = neighbours.shift(y, minimum_m, np.minimum(self._clearance.full_speed_m, room))
        goal_m = 0.0 if self._narrow(config, neighbours, minimum_m, y) else abs(minimum_m - y)
        there = np.maximum(self._reach.speed(way, wanted, goal_m, abs(slope)), self._reach.walking_mps)
        return neighbours.bodies.speed_mps + np.where(reached, there, 0.0)

    def _narrow(self, config: ApproachConfig, neighbours: ObstacleGeometry, minimum_m: float, y_m: float) -> bool:
        """Whether beyond the minimum there is no room for a car that is still turned while it passes."""
        beyond = minimum_m + float(np.sign(minimum_m - y_m)) * config.turned_m
        covers = neighbours.overlap(beyond, self._clearance.full_speed_m) > 0.0
        return bool((covers & neighbours.present).any())

    def _settled(self, config: RestConfig, neighbours: ObstacleGeometry, minimum_m: float, glide: LateralPath) -> float:
        """m/s at which the path, bent as it is, comes to rest before it is too near to bodies beyond the minimum."""
        if max(abs(glide.slope), abs(glide.bend_per_m) * self._reach.radius_m) < STRAIGHT:
            return inf
        if not neighbours.stands.any():
            return max(float(SPEEDS_MPS[-1]), self._reach.walking_mps)
        way, shift = self._reach.at_speeds.rest(glide.slope, glide.bend_per_m)
        room = -neighbours.overlap(minimum_m, 0.0)
        kept = np.minimum(room, self._clearance.full_speed_m)
        side = np.sign(neighbours.bodies.middle_m - minimum_m)
        last = minimum_m + side * (room - kept + config.tolerance_m)  # (K,) place from which there is less than that
        beyond, towards = side[:, None] * (glide.y_m + shift - last[:, None]), side[:, None] * shift > 0.0
        reached = neighbours.stands[:, None] & towards & (neighbours.way_m[:, None] < way)
        worst = beyond.max(axis=0, where=reached, initial=-1.0)
        settled = float(np.interp(0.0, np.maximum.accumulate(worst), SPEEDS_MPS))
        return max(settled, self._reach.walking_mps)

    def _unwound(self, neighbours: ObstacleGeometry, lane: Lane, glide: LateralPath) -> float:
        """m/s up to which the wheels are straight before the path is headed at what is beside it too steeply.

        The slope is largest where they are, p + b^2 / (2 j), and j falls with the speed (`settling`).
        """
        if abs(glide.bend_per_m) * self._reach.radius_m < STRAIGHT:
            return inf
        side = 1.0 if glide.bend_per_m > 0.0 else -1.0
        largest = self._reach.path_between(neighbours.between(lane, glide.y_m), glide.y_m)[side > 0.0]
        peak = side * glide.slope + 0.5 * glide.bend_per_m**2 / self._reach.at_speeds.steering_per_m2
        unwound = float(np.interp(largest + STRAIGHT, peak, SPEEDS_MPS, right=inf))
        return max(unwound, self._reach.walking_mps)


def eased(speed_mps: float) -> float:
    """m/s, the least that is asked of a car at that speed for what comfortable braking is enough for."""
    return speed_mps - max(min(EASY_MPS, EASY_SHARE * speed_mps), LEAST_MPS)


def _comfortable(config: SpeedConfig, speed_mps: float) -> float:
    """m/s, the least that is asked of a car at that speed; -inf where its comfort does not count."""
    return -inf if config.easing is None else eased(speed_mps)


def braked(
    speed_mps: float, closing_mps: Floats, way_m: Floats, before_m: float, firm_mps2: float, full_mps2: float
) -> Floats:
    """(K,) m/s, the least that is asked of a car before each body: it brakes beyond comfort as far as a stop needs.

    Stopped is who has the speed of the body before it has come nearer than `before_m`; where not even the full brake
    does that, there is no least.
    """
    needed = np.maximum(closing_mps, 0.0) ** 2 / (2.0 * np.maximum(way_m - before_m, SHORTEST_M))
    hard = (needed - firm_mps2) / (full_mps2 - firm_mps2)
    begins = speed_mps - max(min(HARD_MPS, HARD_SHARE * speed_mps), HARD_LEAST_MPS)
    return np.where(hard > 0.0, np.where(hard < 1.0, begins - hard, -np.inf), eased(speed_mps))
