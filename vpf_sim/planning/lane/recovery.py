"""Recovery from a dead end: a car that stands before a blocked road turns out on its tightest curve.

There is no reverse gear. An obstacle that is detected late, or a false one, may close the gap in which the car already
is. A shift from the road's direction and back before the obstacle (`vpf_sim.planning.lane.kinematic_limits`) is then
impossible, but not the turn of `vpf_sim.planning.lane.recovery_candidates`. It leads far from the road's direction,
where the camera sees little of the road, so the lane is known by odometry.
"""

from dataclasses import dataclass, replace
from math import asin, atan, cos, sin, tan

import numpy as np

from vpf_sim.geometry import vehicle_from_world, wrap_angle
from vpf_sim.planning.lane.config import LanePlannerConfig
from vpf_sim.planning.lane.frame import Lane, LaneObstacles, locate, place
from vpf_sim.planning.lane.kinematic_limits import rear_m
from vpf_sim.planning.lane.recovery_candidates import STEP_M, Candidates, candidates, separation
from vpf_sim.planning.lane.recovery_config import RecoveryConfig
from vpf_sim.types import DriverSetup, Floats, Observation, Obstacles, Reference, RoadEdges

COARSE = 8  # steps
STANDING_MPS = 0.1
STRAIGHT_RAD = 0.02  # wheels that turn by less do not slow the car


@dataclass(frozen=True, slots=True)
class _Start:
    """Where a manoeuvre began."""

    lane: Lane
    pose: Floats  # (3,)

    def lane_at(self, observation: Observation) -> Lane:
        """The lane now by odometry."""
        before = self.lane
        ahead, right = vehicle_from_world(np.array([observation.x_m, observation.y_m]), self.pose)
        cosine, sine = cos(before.heading_rad), sin(before.heading_rad)
        along, across = float(cosine * ahead + sine * right), float(cosine * right - sine * ahead)
        bend = before.curvature_per_m * along
        heading = wrap_angle(before.heading_rad + bend - wrap_angle(observation.yaw_rad - float(self.pose[2])))
        return replace(before, y_m=before.y_m + across - 0.5 * bend * along, heading_rad=heading)


class Recovery:
    """Searches for a manoeuvre while the car stands, and drives it."""

    def __init__(self, config: RecoveryConfig, planner: LanePlannerConfig, setup: DriverSetup) -> None:
        self._config, self._obstacles, self._edge_m = config, planner.obstacles, planner.clearance.edge_m
        self._vehicle, self._dt_s = setup.vehicle, 1.0 / setup.rate_hz
        self._stood_s, self._steering_rad, self._gone_m = 0.0, 0.0, 0.0
        self._start: _Start | None = None
        self._manoeuvre: Candidates | None = None
        self._last_m: float | None = None  # y after a manoeuvre: the camera may take another lane for the own one

    @property
    def manoeuvre(self) -> Candidates | None:
        """The one that is driven."""
        return self._manoeuvre

    def lane(self, road: RoadEdges, observation: Observation) -> Lane:
        """The lane by odometry on a manoeuvre, else as the camera sees it, counted from the own one."""
        if self._manoeuvre is not None and self._start is not None:
            lane = self._start.lane_at(observation)
            self._last_m = lane.y_m
            return lane
        lane = locate(road)
        if self._last_m is None:
            return lane
        shift_m = round((self._last_m - lane.y_m) / road.lane_width_m) * road.lane_width_m
        self._last_m = lane.y_m + shift_m
        return replace(lane, y_m=self._last_m, left_m=lane.left_m + shift_m, right_m=lane.right_m + shift_m)

    def update(
        self, lane: Lane, obstacles: Obstacles, observation: Observation, reference: Reference
    ) -> Reference | None:
        """The reference on the manoeuvre after a step of 1 / rate_hz; None where none is driven."""
        self._estimate_steering(observation)
        if self._manoeuvre is None:
            stands = observation.speed_mps < STANDING_MPS and reference.speed_mps < STANDING_MPS
            self._stood_s = self._stood_s + self._dt_s if stands else 0.0
            if self._stood_s >= self._config.standing_s:
                self._stood_s -= self._config.again_s
                self._begin(lane, obstacles, observation)
        return self._follow(lane, observation)

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
        near = place(obstacles, lane)
        near = near.chosen(near.along_m < self._config.ahead_m)
        per_m = self._config.steering_radps / self._config.steering_mps
        for lock in self._config.candidates.locks:
            found = candidates(lane, self._steering_rad, self._vehicle, per_m, lock, self._config.candidates)
            self._manoeuvre = self._best(found, lane, near)
            if self._manoeuvre is not None:
                self._start, self._gone_m = _Start(lane, observation.pose), 0.0
                return

    def _best(self, found: Candidates, lane: Lane, near: LaneObstacles) -> Candidates | None:
        """The drivable candidate that turns least and keeps the largest clearance."""
        beyond_m, length_m = self._config.candidates.beyond_m, self._obstacles.length_m
        found = found.chosen(found.end + round(beyond_m / STEP_M) < found.along_m.shape[1])
        for every in COARSE, 1:  # most candidates fail at a coarse check
            if not len(found):
                return None
            apart, edges = separation(found, lane, near, length_m, self._vehicle, beyond_m, every)
            least = apart.min(axis=1)
            drivable = (least >= self._config.clearance_m) & (edges >= self._edge_m)
            found, least = found.chosen(drivable), least[drivable]
        if not len(found):
            return None
        config = self._config.cost
        cost = np.abs(found.turned_rad).max(axis=1) + config.length_per_m * found.end * STEP_M
        cost = cost - config.clearance_per_m * np.minimum(least, config.enough_m)
        return found.one(int(np.argmin(cost)))

    def _follow(self, lane: Lane, observation: Observation) -> Reference | None:
        """The reference on the manoeuvre, until the car is along the road again."""
        if self._manoeuvre is None:
            return None
        slip = atan(self._vehicle.l_r_m / self._vehicle.wheelbase_m * tan(self._steering_rad))
        self._gone_m += observation.speed_mps * cos(slip) * self._dt_s  # of the rear axle
        step = int(self._gone_m / STEP_M)
        is_past = step > int(self._manoeuvre.end[0]) + round(self._config.settling_m / STEP_M)
        if is_past or step + 2 >= self._manoeuvre.along_m.shape[1]:
            self._manoeuvre, self._stood_s = None, 0.0
            return None
        return self._reference(self._manoeuvre.rest(step), self._gone_m / STEP_M - step, lane, observation)

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
