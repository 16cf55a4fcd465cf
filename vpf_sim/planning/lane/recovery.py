"""Recovery from a dead end: a car that stands before a blocked road turns out on its tightest curve.

There is no reverse gear. An obstacle that is detected late, or a false one, may close the gap in which the car already
is. A shift from the road's direction and back before the obstacle (`vpf_sim.planning.lane.kinematic_limits`) is then
impossible, but not the turn of `vpf_sim.planning.lane.recovery_candidates`. It leads far from the road's direction,
where the camera sees little of the road, so the lane is known by odometry.
"""

from dataclasses import dataclass, replace
from itertools import product
from math import asin, atan, ceil, cos, sin, tan

import numpy as np

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.geometry import vehicle_from_world, wrap_angle
from vpf_sim.planning.lane.frame import Lane, locate, place
from vpf_sim.planning.lane.kinematic_limits import rear_m
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig
from vpf_sim.planning.lane.recovery_candidates import STEP_M, Blockers, Candidates, candidates, separation
from vpf_sim.planning.lane.recovery_config import RecoveryConfig
from vpf_sim.planning.lane.speed.creep import STANDING_MPS
from vpf_sim.types import Floats, Obstacles, Reference, RoadEdges

COARSE = 8  # steps
STRAIGHT_RAD = 0.02  # wheels that turn by less do not slow the car


@dataclass(frozen=True, slots=True)
class _Start:
    """Where a manoeuvre began: lane, pose and obstacles."""

    lane: Lane
    pose: Floats  # (3,)
    blockers: Blockers
    known: frozenset[int]  # their identities

    def lane_at(self, observation: Observation) -> tuple[Lane, float]:
        """The lane now by odometry, and m along the road from the start."""
        before = self.lane
        ahead, right = vehicle_from_world(np.array([observation.x_m, observation.y_m]), self.pose)
        cosine, sine = cos(before.heading_rad), sin(before.heading_rad)
        along, across = float(cosine * ahead + sine * right), float(cosine * right - sine * ahead)
        bend = before.curvature_per_m * along
        heading = wrap_angle(before.heading_rad + bend - wrap_angle(observation.yaw_rad - float(self.pose[2])))
        return replace(before, y_m=before.y_m + across - 0.5 * bend * along, heading_rad=heading), along


class Recovery:
    """Searches for a manoeuvre while the car stands, and drives it."""

    def __init__(self, config: RecoveryConfig, planner: LanePlannerConfig, setup: DriverSetup) -> None:
        self._config, self._obstacles, self._edge_m = config, planner.obstacles, planner.clearance.edge_m
        self._vehicle, self._dt_s = setup.vehicle, 1.0 / setup.rate_hz
        self._stood_s = 0.0
        self._steering_rad = 0.0
        self._gone_m = 0.0
        self._clearance_m = config.clearance_m  # of the manoeuvre
        self._start: _Start | None = None  # kept until the road is seen again
        self._manoeuvre: Candidates | None = None
        self._left_road = False  # since then lanes are counted here,
        self._lanes, self._last_m = 0, 0.0  # by how many the seen one is off, and where the car was

    @property
    def manoeuvre(self) -> Candidates | None:
        """The one that is driven."""
        return self._manoeuvre

    def lane(self, road: RoadEdges, observation: Observation) -> Lane:
        """The lane as the camera sees it, or by odometry until both agree.

        The camera may take another lane for the own one on the way; odometry tells which it is.
        """
        seen = locate(road)
        if self._start is None:
            if self._left_road:
                self._lanes = _lanes(self._last_m - seen.y_m, road)
            return self._counted(seen, road)
        config, (lane, along) = self._config.relocation, self._start.lane_at(observation)
        if config is None and self._manoeuvre is None:
            self._start = None
            return self._counted(seen, road)
        lanes = _lanes(lane.y_m - seen.y_m, road)
        aside = seen.y_m + lanes * road.lane_width_m - lane.y_m
        if config is None:
            return lane
        agrees = abs(aside) < config.lateral_m and abs(seen.heading_rad - lane.heading_rad) < config.heading_rad
        is_back = agrees and abs(lane.heading_rad) < self._config.back_rad
        if self._manoeuvre is None and (is_back or along > config.way_m):
            self._start, self._lanes = None, lanes
            return self._counted(seen, road)
        return lane

    def _counted(self, seen: Lane, road: RoadEdges) -> Lane:
        """The lane as the camera sees it, shifted to the own one."""
        counted = _shifted(seen, self._lanes * road.lane_width_m)
        self._last_m = counted.y_m
        return counted

    def update(
        self, lane: Lane, obstacles: Obstacles, observation: Observation, reference: Reference
    ) -> Reference | None:
        """The reference on the manoeuvre after a step of 1 / rate_hz; None where none is driven.

        A car that is still turned when its manoeuvre is blocked stands until there is another one.
        """
        self._estimate_steering(observation)
        turned = self._start is not None and abs(lane.heading_rad) > self._config.back_rad
        if self._manoeuvre is None:
            stands = observation.speed_mps < STANDING_MPS and (turned or reference.speed_mps < STANDING_MPS)
            self._stood_s = self._stood_s + self._dt_s if stands else 0.0
            if self._stood_s >= self._config.standing_s:
                self._stood_s -= self._config.again_s
                self._begin(lane, obstacles, observation)
        followed = self._follow(lane, obstacles, observation)
        if followed is None and turned:
            return Reference(observation.yaw_rad, 0.0, 0.0)
        return followed

    def _estimate_steering(self, observation: Observation) -> None:
        """Estimate the steering angle from the yaw rate; at standstill the wheels stay as they are."""
        vehicle = self._vehicle
        if observation.speed_mps > self._config.measured_mps:
            bend = vehicle.l_r_m * observation.yaw_rate_radps / observation.speed_mps
            limit, slip = vehicle.steering_limit_rad, asin(min(max(bend, -1.0), 1.0))
            steering = atan(vehicle.wheelbase_m / vehicle.l_r_m * tan(slip))
            self._steering_rad = min(max(steering, -limit), limit)

    def _begin(self, lane: Lane, obstacles: Obstacles, observation: Observation) -> None:
        """Search for a manoeuvre from here; before a moving obstacle the car waits."""
        if np.any((obstacles.speed_mps > 0.0) & (obstacles.forward_m < self._config.ahead_m)):
            return
        blockers = self._blockers(lane, obstacles, observation)
        per_m = self._config.steering_radps / self._config.steering_mps
        config = self._config.candidates
        found = [candidates(lane, self._steering_rad, self._vehicle, per_m, lock, config) for lock in config.locks]
        here, _ = separation(found[0].one(0), lane, blockers, self._vehicle, config.beyond_m)
        clearances_m = [self._config.clearance_m]
        if self._config.tight_share is not None:
            clearances_m += [self._config.tight_share * self._config.clearance_m]
            clearances_m += [self._kept(clearances_m[-1], here[0])]  # as much as there is now
        for clearance_m, some in product(dict.fromkeys(clearances_m), found):
            self._manoeuvre = self._best(some, lane, blockers, clearance_m)
            if self._manoeuvre is not None:
                pose = observation.pose
                self._start = _Start(lane, pose, blockers, frozenset(obstacles.identity.tolist()))
                self._gone_m, self._clearance_m, self._left_road = 0.0, clearance_m, True
                return

    def _blockers(self, lane: Lane, obstacles: Obstacles, observation: Observation) -> Blockers:
        """The obstacles near the car: those at the start of the manoeuvre, and narrow ones detected since.

        Seen at an angle, a known obstacle may be detected once more as a wide one.
        """
        length_m, parts, new_config = self._obstacles.length_m, self._obstacles.parts, self._config.new_obstacles
        if self._start is None:
            blockers = Blockers.of(place(obstacles, lane, parts), length_m, self._config.candidates.beyond_m)
        else:
            _, gone = self._start.lane_at(observation)
            known = replace(self._start.blockers, along_m=self._start.blockers.along_m - gone)
            if new_config is None:
                return known.select(known.along_m < self._config.ahead_m)
            new = np.array([name not in self._start.known for name in obstacles.identity.tolist()], np.bool_)
            fresh = place(obstacles.select(new & (obstacles.width_m < new_config.width_m)), lane, parts)
            blockers = known.concatenate(Blockers.of(fresh, length_m, new_config.beyond_m))
        return blockers.select(blockers.along_m < self._config.ahead_m)

    def _best(self, found: Candidates, lane: Lane, blockers: Blockers, clearance_m: float) -> Candidates | None:
        """The drivable candidate that turns least and keeps the largest clearance."""
        found = found.select(found.end + round(self._config.candidates.beyond_m / STEP_M) < found.along_m.shape[1])
        for every in COARSE, 1:  # most candidates fail at a coarse check
            if not len(found):
                return None
            apart, edges = separation(found, lane, blockers, self._vehicle, self._config.candidates.beyond_m, every)
            begins_m = self._config.begin.way_m if self._config.begin is not None else 0.0
            least = apart[:, ceil(begins_m / STEP_M / every) :].min(axis=1)
            drivable = (apart.min(axis=1) >= self._kept(clearance_m, apart[0])) & (least >= clearance_m)
            drivable &= edges >= self._edge_m
            found, least = found.select(drivable), least[drivable]
        if not len(found):
            return None
        config = self._config.cost
        cost = np.abs(found.turned_rad).max(axis=1) + config.length_per_m * found.end * STEP_M
        cost = cost - config.clearance_per_m * np.minimum(least, config.enough_m)
        return found.one(int(np.argmin(cost)))

    def _follow(self, lane: Lane, obstacles: Obstacles, observation: Observation) -> Reference | None:
        """The reference on the manoeuvre, until it ends or is blocked."""
        if self._manoeuvre is None:
            return None
        last = int(self._gone_m / STEP_M)
        slip = atan(self._vehicle.l_r_m / self._vehicle.wheelbase_m * tan(self._steering_rad))
        self._gone_m += observation.speed_mps * cos(slip) * self._dt_s  # of the rear axle
        step = int(self._gone_m / STEP_M)
        rest = self._manoeuvre.rest(step)
        if step > last:
            blockers = self._blockers(lane, obstacles, observation)
            if self._has_ended(step, blockers) or not self._is_free(rest, lane, blockers):
                self._manoeuvre, self._stood_s = None, 0.0
                return None
        return self._reference(rest, self._gone_m / STEP_M - step, lane, observation)

    def _kept(self, clearance_m: float, apart_m: Floats) -> float:
        """m to obstacles that a manoeuvre keeps: the clearance, or as much as there is where it begins."""
        if self._config.begin is None:
            return clearance_m
        return min(clearance_m, max(float(apart_m[0]), self._config.begin.least_m))

    def _has_ended(self, step: int, blockers: Blockers) -> bool:
        """Whether the car is along the road again and past all obstacles that may be long."""
        assert self._manoeuvre is not None
        if step + 2 >= self._manoeuvre.along_m.shape[1]:
            return True
        is_past = step > int(self._manoeuvre.end[0]) + round(self._config.settling_m / STEP_M)
        long = self._config.passing
        if long is None or not is_past:
            return is_past
        front = blockers.along_m - 0.5 * self._vehicle.length_m
        beside = (front < 0.0) & (blockers.along_m + long.length_m > -0.5 * self._vehicle.length_m)
        return not bool(np.any(beside & (blockers.width_m > long.width_m)))

    def _is_free(self, rest: Candidates, lane: Lane, blockers: Blockers) -> bool:
        """Whether the rest of the manoeuvre is free."""
        if self._config.recheck_share is None:
            return True
        here = -self._vehicle.l_r_m * cos(lane.heading_rad)
        rest = replace(rest, along_m=rest.along_m - rest.along_m[0, 0] + here)
        apart, _ = separation(rest, lane, blockers, self._vehicle, self._config.candidates.beyond_m)
        return bool(apart.min() >= self._config.recheck_share * self._kept(self._clearance_m, apart[0]))

    def _reference(self, rest: Candidates, share: float, lane: Lane, observation: Observation) -> Reference:
        """Heading, its rate and speed on the manoeuvre, a `share` of a step after the first that is left."""
        y = (1.0 - share) * float(rest.y_m[0, 0]) + share * float(rest.y_m[0, 1])
        pull = self._config.correction_rad_per_m * (y - rear_m(lane, self._vehicle)) * cos(lane.heading_rad)
        most = self._config.correction_rad
        before, soon = rest.turned_rad[0, :2].tolist()
        turned = (1.0 - share) * before + share * soon
        heading = observation.yaw_rad + lane.heading_rad + turned + min(max(pull, -most), most)
        turns = np.ptp(rest.steering_rad[0, : round(self._config.steering_ahead_m / STEP_M)]) > STRAIGHT_RAD
        speed = self._config.steering_mps if turns else self._config.speed_mps
        return Reference(wrap_angle(heading), speed, (soon - before) / STEP_M * observation.speed_mps)


def _lanes(shift_m: float, road: RoadEdges) -> int:
    """The shift in whole lanes."""
    return round(shift_m / road.lane_width_m)


def _shifted(lane: Lane, shift_m: float) -> Lane:
    return replace(lane, y_m=lane.y_m + shift_m, left_m=lane.left_m + shift_m, right_m=lane.right_m + shift_m)
