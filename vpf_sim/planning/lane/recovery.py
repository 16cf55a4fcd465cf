"""Out of a dead end: a car that stands before a blocked road turns out on its tightest curve where that is drivable.

There is no reverse gear. A body that is told late, or one that is not there, may close the gap in which the car is
already; what `vpf_sim.planning.lane.kinematic_limits` counts on, a shift from the road's direction and back to it
before the body, is then out of reach, but not the turn of `vpf_sim.planning.lane.recovery_candidates`. It leads far
from the road's direction, where the camera sees little of the road: where the car is on it is known from before and
from the own motion.
"""

from dataclasses import dataclass, replace
from itertools import product
from math import asin, atan, ceil, cos, sin, tan

import numpy as np

from vpf_sim.geometry import vehicle_from_world, wrap_angle
from vpf_sim.planning.lane.config import ObstacleConfig
from vpf_sim.planning.lane.frame import Lane, locate, place
from vpf_sim.planning.lane.kinematic_limits import rear_m
from vpf_sim.planning.lane.recovery_candidates import STEP_M, Blockers, Courses, courses, separation
from vpf_sim.planning.lane.recovery_config import RecoveryConfig
from vpf_sim.planning.lane.speed.creep import STANDING_MPS
from vpf_sim.types import Floats, Observation, Obstacles, Reference, RoadEdges, VehicleModel

COARSE = 8  # steps
STRAIGHT_RAD = 0.02  # wheels that turn by less do not slow the car


@dataclass(frozen=True, slots=True)
class _Start:
    """Where a course began: the road as it was seen, or known from before, the pose, and what was known to stand."""

    lane: Lane
    pose: Floats  # (3,)
    bodies: Blockers
    known: frozenset[int]  # their identities

    def lane_at(self, observation: Observation) -> tuple[Lane, float]:
        """Where the car is on the road now, by its own motion, and how far along it from the start."""
        before = self.lane
        ahead, right = vehicle_from_world(np.array([observation.x_m, observation.y_m]), self.pose)
        cosine, sine = cos(before.heading_rad), sin(before.heading_rad)
        along, across = float(cosine * ahead + sine * right), float(cosine * right - sine * ahead)
        bend = before.curvature_per_m * along
        heading = wrap_angle(before.heading_rad + bend - wrap_angle(observation.yaw_rad - float(self.pose[2])))
        return replace(before, y_m=before.y_m + across - 0.5 * bend * along, heading_rad=heading), along


class Recovery:
    """Looks for a course while the car stands, and remembers the one that is driven."""

    def __init__(
        self, config: RecoveryConfig, edge_m: float, obstacles: ObstacleConfig, vehicle: VehicleModel, rate_hz: float
    ) -> None:
        self._config = config
        self._edge_m = edge_m
        self._obstacles = obstacles
        self._vehicle = vehicle
        self._dt_s = 1.0 / rate_hz
        self._stood_s = 0.0
        self._steering_rad = 0.0
        self._gone_m = 0.0
        self._clearance_m = config.clearance_m  # that the course keeps
        self._start: _Start | None = None  # kept until the road is seen again
        self._course: Courses | None = None
        self._left_road = False  # whether any course was driven: since then lanes are counted here,
        self._lanes, self._last_m = 0, 0.0  # by how many the seen one is off, and where the car was

    @property
    def is_driven(self) -> bool:
        """Whether a course is."""
        return self._course is not None

    @property
    def manoeuvre(self) -> Courses | None:
        """The one that is driven."""
        return self._course

    def lane(self, road: RoadEdges, observation: Observation) -> Lane:
        """Where the car is on the road: as it is seen, or by the own motion until that is where the road is seen.

        Which of the lanes is the own one may be lost on the way; it is known by the own motion.
        """
        seen = locate(road)
        if self._start is None:
            if self._left_road:
                self._lanes = _lanes(self._last_m - seen.y_m, road)
            return self._counted(seen, road)
        config, (lane, along) = self._config.relocation, self._start.lane_at(observation)
        if config is None and self._course is None:
            self._start = None
            return self._counted(seen, road)
        lanes = _lanes(lane.y_m - seen.y_m, road)
        aside = seen.y_m + lanes * road.lane_width_m - lane.y_m
        if config is None:
            return lane
        agrees = abs(aside) < config.lateral_m and abs(seen.heading_rad - lane.heading_rad) < config.heading_rad
        is_back = agrees and abs(lane.heading_rad) < self._config.back_rad
        if self._course is None and (is_back or along > config.way_m):
            self._start, self._lanes = None, lanes
            return self._counted(seen, road)
        return lane

    def _counted(self, seen: Lane, road: RoadEdges) -> Lane:
        """The lane as it is seen, from the own one."""
        counted = _shifted(seen, self._lanes * road.lane_width_m)
        self._last_m = counted.y_m
        return counted

    def update(
        self, lane: Lane, obstacles: Obstacles, observation: Observation, reference: Reference
    ) -> Reference | None:
        """One step of 1 / rate_hz: the reference on the course; None where none is driven, or it has ended.

        A car that is still turned when its course turns out to lead nowhere stands until there is another.
        """
        self._feel(observation)
        turned = self._start is not None and abs(lane.heading_rad) > self._config.back_rad
        if self._course is None:
            stands = observation.speed_mps < STANDING_MPS and (turned or reference.speed_mps < STANDING_MPS)
            self._stood_s = self._stood_s + self._dt_s if stands else 0.0
            if self._stood_s >= self._config.standing_s:
                self._stood_s -= self._config.again_s
                self._begin(lane, obstacles, observation)
        followed = self._follow(lane, obstacles, observation)
        if followed is None and turned:
            return Reference(observation.yaw_rad, 0.0, 0.0)
        return followed

    def _feel(self, observation: Observation) -> None:
        """How the car slips and its wheels stand; they stay as they are while the car does."""
        vehicle = self._vehicle
        if observation.speed_mps > self._config.measured_mps:
            bend = vehicle.l_r_m * observation.yaw_rate_radps / observation.speed_mps
            limit, slip = vehicle.steering_limit_rad, asin(min(max(bend, -1.0), 1.0))
            steering = atan(vehicle.wheelbase_m / vehicle.l_r_m * tan(slip))
            self._steering_rad = min(max(steering, -limit), limit)

    def _begin(self, lane: Lane, obstacles: Obstacles, observation: Observation) -> None:
        """Look for a course from here; before what moves the car waits."""
        if np.any((obstacles.speed_mps > 0.0) & (obstacles.forward_m < self._config.ahead_m)):
            return
        bodies = self._bodies(lane, obstacles, observation)
        per_m = self._config.steering_radps / self._config.steering_mps
        config = self._config.candidates
        found = [courses(lane, self._steering_rad, self._vehicle, per_m, lock, config) for lock in config.locks]
        here, _ = separation(found[0].one(0), lane, bodies, self._vehicle, config.beyond_m)
        clearances_m = [self._config.clearance_m]
        if self._config.tight is not None:
            clearances_m += [self._config.tight.share * self._config.clearance_m]
            clearances_m += [self._kept(clearances_m[-1], here[0])]  # as much as there is now
        for clearance_m, some in product(dict.fromkeys(clearances_m), found):
            self._course = self._best(some, lane, bodies, clearance_m)
            if self._course is not None:
                pose = np.array([observation.x_m, observation.y_m, observation.yaw_rad])
                self._start = _Start(lane, pose, bodies, frozenset(obstacles.identity.tolist()))
                self._gone_m, self._clearance_m, self._left_road = 0.0, clearance_m, True
                return

    def _bodies(self, lane: Lane, obstacles: Obstacles, observation: Observation) -> Blockers:
        """What stands near: on a course what was known where it began, and what is told since, which stays so for the
        next course that begins on this one.

        A body's sides are told as seen from the car. One that is wide is seen at an angle as another body, and wide
        things that were not seen from the road's direction are none.
        """
        length_m, parts, new_config = self._obstacles.length_m, self._obstacles.parts, self._config.new_obstacles
        if self._start is None:
            bodies = Blockers.of(place(obstacles, lane, parts), length_m, self._config.candidates.beyond_m)
        else:
            _, gone = self._start.lane_at(observation)
            known = replace(self._start.bodies, along_m=self._start.bodies.along_m - gone)
            if new_config is None:
                return known.chosen(known.along_m < self._config.ahead_m)
            new = np.array([name not in self._start.known for name in obstacles.identity.tolist()], np.bool_)
            fresh = place(obstacles.chosen(new & (obstacles.width_m < new_config.width_m)), lane, parts)
            bodies = known.concatenate(Blockers.of(fresh, length_m, new_config.beyond_m))
        return bodies.chosen(bodies.along_m < self._config.ahead_m)

    def _best(self, found: Courses, lane: Lane, bodies: Blockers, clearance_m: float) -> Courses | None:
        """Of the courses that keep far enough from all the one that turns least and keeps farthest.

        On the first BEGINS_M of one the car may be as near to a body as it is now.
        """
        found = found.chosen(found.end + round(self._config.candidates.beyond_m / STEP_M) < found.along_m.shape[1])
        for every in COARSE, 1:  # most courses fail at a coarse look
            if not len(found):
                return None
            apart, edges = separation(found, lane, bodies, self._vehicle, self._config.candidates.beyond_m, every)
            begins_m = self._config.begin.way_m if self._config.begin is not None else 0.0
            least = apart[:, ceil(begins_m / STEP_M / every) :].min(axis=1)
            drivable = (apart.min(axis=1) >= self._kept(clearance_m, apart[0])) & (least >= clearance_m)
            drivable &= edges >= self._edge_m
            found, least = found.chosen(drivable), least[drivable]
        if not len(found):
            return None
        config = self._config.cost
        cost = np.abs(found.turned_rad).max(axis=1) + config.length_per_m * found.end * STEP_M
        cost = cost - config.clearance_per_m * np.minimum(least, config.enough_m)
        return found.one(int(np.argmin(cost)))

    def _follow(self, lane: Lane, obstacles: Obstacles, observation: Observation) -> Reference | None:
        """On along the course, until it leads back to the road's direction, or nowhere any longer."""
        if self._course is None:
            return None
        last = int(self._gone_m / STEP_M)
        slip = atan(self._vehicle.l_r_m / self._vehicle.wheelbase_m * tan(self._steering_rad))
        self._gone_m += observation.speed_mps * cos(slip) * self._dt_s  # of the rear axle
        step = int(self._gone_m / STEP_M)
        rest = self._course.rest(step)
        if step > last:
            bodies = self._bodies(lane, obstacles, observation)
            if self._has_ended(step, bodies) or not self._is_free(rest, lane, bodies):
                self._course, self._stood_s = None, 0.0
                return None
        return self._reference(rest, self._gone_m / STEP_M - step, lane, observation)

    def _kept(self, clearance_m: float, apart_m: Floats) -> float:
        """m to obstacles that a manoeuvre keeps: the clearance, or as much as there is where it begins."""
        if self._config.begin is None:
            return clearance_m
        return min(clearance_m, max(float(apart_m[0]), self._config.begin.least_m))

    def _has_ended(self, step: int, bodies: Blockers) -> bool:
        """Whether the car goes along the road again and has passed all bodies that may be long: no side was seen."""
        assert self._course is not None
        if step + 2 >= self._course.along_m.shape[1]:
            return True
        is_past = step > int(self._course.end[0]) + round(self._config.settling_m / STEP_M)
        long = self._config.passing
        if long is None or not is_past:
            return is_past
        front = bodies.along_m - 0.5 * self._vehicle.length_m
        beside = (front < 0.0) & (bodies.along_m + long.length_m > -0.5 * self._vehicle.length_m)
        return not bool(np.any(beside & (bodies.width_m > long.width_m)))

    def _is_free(self, rest: Courses, lane: Lane, bodies: Blockers) -> bool:
        """Whether what is left of a course still keeps from all, as far as is known now."""
        if self._config.recheck is None:
            return True
        here = -self._vehicle.l_r_m * cos(lane.heading_rad)
        rest = replace(rest, along_m=rest.along_m - rest.along_m[0, 0] + here)
        apart, _ = separation(rest, lane, bodies, self._vehicle, self._config.candidates.beyond_m)
        return bool(apart.min() >= self._config.recheck.share * self._kept(self._clearance_m, apart[0]))

    def _reference(self, rest: Courses, share: float, lane: Lane, observation: Observation) -> Reference:
        """Heading, its rate and speed where the course is now: a share of a step after the first that is left."""
        y = (1.0 - share) * float(rest.y_m[0, 0]) + share * float(rest.y_m[0, 1])
        pull = self._config.tracking.rad_per_m * (y - rear_m(lane, self._vehicle)) * cos(lane.heading_rad)
        most = self._config.tracking.most_rad
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
