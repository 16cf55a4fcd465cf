"""From the field's minimum to heading and speed: how the robust variant moves across the lane.

The minimum jumps when a body appears; the reference glides after it on a path y_r of the rear axle that the car can
follow (`vpf_sim.planning.lane.lateral_path`). The heading is that path's direction, with psi_r the road's,

    psi_d = lag(psi_r + asin(k (y_r - y) / v)) + asin(y_r'),    d psi_d / dt = d lag / dt + v y_r'' / sqrt(1 - y_r'^2).

A bicycle's centre of mass moves at yaw + slip, and d psi / dt = v sin(slip) / l_r, so its yaw is its course through a
lag of l_r / v: l_r / v d psi / dt = chi - psi. What is known of the centre of mass, the road's direction, goes through
that very lag and so has the slip of a bend (l_r / R); the rear axle has none.

What that and the speed by what is ahead are worth is seen without them: with `motion = "direct"` psi_d leads to the
minimum itself, and with `speed = "constant"` v_d stays the reference speed, as in the paper.
"""

from math import asin, exp, sqrt

import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.gap_cost import ROW_M
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits, rear_m
from vpf_sim.planning.lane.lateral_path import LateralPath
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.reference_config import LaneReferenceConfig
from vpf_sim.planning.lane.speed.limits import SpeedLimits
from vpf_sim.planning.lane.stopping_distance import stopping_way
from vpf_sim.types import Reference, VehicleModel

SLOWEST_CLOSING_MPS = 0.5
RESTS_SLOPE = 0.02  # of a path that has not left its place yet
HOLDS_M = 7.0  # bumper to face: from farther away a gap may still prove wider, and is entered from before it
WAITS_S = 0.4  # besides the way that a shift takes


class LaneReference:
    """The reference's path across the lane, the heading that follows it, and the speed."""

    def __init__(
        self,
        config: LaneReferenceConfig,
        vehicle: VehicleModel,
        speed_reference_mps: float,
        rate_hz: float,
        reach: KinematicLimits,
    ) -> None:
        self._config = config
        self._vehicle = vehicle
        self._dt_s = 1.0 / rate_hz
        self._shift_m = config.shift_s * speed_reference_mps
        self._pace = SpeedLimits(config, speed_reference_mps, rate_hz, reach)
        self._reach = reach
        self.y_m: float | None = None
        self.restart(speed_reference_mps)

    def restart(self, speed_mps: float) -> None:
        """Begin anew from where the car is."""
        self._pace.restart(speed_mps)
        self._heading_rad: float | None = None
        self._glide: LateralPath | None = None

    def update(
        self, lane: Lane, neighbours: ObstacleGeometry, minimum_m: float, yaw_rad: float, speed_mps: float
    ) -> Reference:
        """One step of 1 / rate_hz towards the field's minimum."""
        wanted = self._pace.update(lane, neighbours, minimum_m, speed_mps, self._glide)
        if self._config.motion == "direct":
            self.y_m = minimum_m
            return Reference(self._straight(lane, minimum_m, yaw_rad, speed_mps), wanted)
        rear = rear_m(lane, self._vehicle)
        if self._glide is None:
            self._glide = LateralPath(self._config, self._reach, rear, self._shift_m)
        between, time_s, flanks = lane, np.inf, (np.inf, np.inf)
        if len(neighbours):
            between = neighbours.between(lane, self._glide.y_m)
            flanks = neighbours.flanks(self._glide.y_m, self._glide.slope)
            time_s = self._time_left(neighbours, self._glide.y_m, speed_mps)
            minimum_m = self._goal(self._glide, neighbours, minimum_m, speed_mps)
        self._glide.advance(between, minimum_m, time_s, speed_mps, speed_mps * self._dt_s, flanks)
        self._glide.hold(rear)
        self.y_m = self._glide.y_m
        heading, rate = self._heading(lane, flanks, self._glide, yaw_rad, speed_mps)
        return Reference(heading, wanted, rate)

    def _time_left(self, neighbours: ObstacleGeometry, y_m: float, speed_mps: float) -> float:
        """s until the first body is reached that stands where y_r is now."""
        way = neighbours.way_m
        hit = (neighbours.overlap(y_m, self._config.minimum_clearance_m) > 0.0) & (way > 0.0)
        closing = np.maximum(max(speed_mps, self._reach.walking_mps) - neighbours.bodies.speed_mps, SLOWEST_CLOSING_MPS)
        return float((way / closing).min(where=hit, initial=np.inf))

    def _goal(self, glide: LateralPath, neighbours: ObstacleGeometry, minimum_m: float, speed_mps: float) -> float:
        """Where the path shall lead now, on its way to the minimum past bodies."""
        if self._waits(glide, neighbours, minimum_m, speed_mps):
            minimum_m = glide.y_m
        else:
            minimum_m = self._held(glide, neighbours, minimum_m, speed_mps)
        return neighbours.kept_beside(glide.y_m, minimum_m)

    def _waits(self, glide: LateralPath, neighbours: ObstacleGeometry, minimum_m: float, speed_mps: float) -> bool:
        """Whether there is more way than it takes before the first body for which the path must leave where it is.

        From nearer a body's side is known better, and the own lane is left no longer than it must be: the way back does
        not wait. Where there is no room to spare beside the bodies it does not wait either, nor before one that moves:
        who is still behind it when it is near is no longer let past (`LateralCost`).
        """
        if abs(glide.slope) > RESTS_SLOPE or abs(minimum_m) < abs(glide.y_m):
            return False
        hit = neighbours.hinders(glide.y_m)
        if not hit.any() or (hit & neighbours.moves).any():
            return False
        narrow = neighbours.overlap(minimum_m, self._config.minimum_clearance_m) > 0.0
        if (narrow & neighbours.present).any():
            return False
        needed = float(self._reach.way(abs(minimum_m - glide.y_m), speed_mps))
        needed += WAITS_S * max(speed_mps, self._reach.walking_mps)
        return float(neighbours.way_m[hit].min()) > needed

    def _held(self, glide: LateralPath, neighbours: ObstacleGeometry, minimum_m: float, speed_mps: float) -> float:
        """Where the path shall lead: to the minimum, or where it is soonest straight if no place is free there, either.

        Turned towards a gap that may be none a car has neither the way nor the angle left for another. It goes back to
        its own lane all the same, and holds only near, where it can stop, and not because of what is far behind the
        first that is in its way.
        """
        config, way = self._config, neighbours.way_m
        shut = self._pace.shut(neighbours, minimum_m)
        if not shut.any():
            return minimum_m
        _, shift = self._reach.rest(glide.slope, glide.bend_per_m, np.array([speed_mps]))
        rest_m = glide.y_m + float(shift[0])
        hit = neighbours.stands & (way > 0.0) & (neighbours.overlap(rest_m, config.walking_clearance_m) > 0.0)
        if abs(minimum_m) < abs(rest_m) or not hit.any():
            return minimum_m
        first_m, shut_m = float(way[hit].min()), float(way[shut].min())
        stops = float(stopping_way(speed_mps, config.brake_mps2)) + config.creep_standoff_m < first_m
        return rest_m if stops and shut_m < first_m + ROW_M and min(first_m, shut_m) < HOLDS_M else minimum_m

    def _straight(self, lane: Lane, minimum_m: float, yaw_rad: float, speed_mps: float) -> float:
        """psi_d rad towards the minimum, without a path."""
        left, right = self._reach.between(lane, speed_mps)
        ratio = min(max(self._pull(minimum_m - lane.y_m, speed_mps), -left), right)
        return wrap_angle(yaw_rad + lane.heading_rad + asin(ratio))

    def _pull(self, error_m: float, speed_mps: float) -> float:
        """k (y_r - y) / v."""
        config = self._config
        pull = min(config.correction_per_s, config.correction_per_m * speed_mps) * error_m
        most = min(config.correction_mps, config.correction_ratio * speed_mps)
        return min(max(pull, -most), most) / max(speed_mps, 1.0)

    def _heading(
        self, lane: Lane, flanks: tuple[float, float], glide: LateralPath, yaw_rad: float, speed_mps: float
    ) -> tuple[float, float]:
        """psi_d rad and its rate rad/s."""
        left, right = self._reach.between(lane, speed_mps)
        left, right = max(left, -flanks[1]), max(right, -flanks[0])
        pull = self._pull(glide.y_m - rear_m(lane, self._vehicle), speed_mps)
        ratio = min(max(pull, -left - glide.slope), right - glide.slope)
        course = yaw_rad + lane.heading_rad + asin(min(max(ratio, -1.0), 1.0))
        if self._heading_rad is None:
            self._heading_rad = yaw_rad
        share = 1.0 - exp(-speed_mps * self._dt_s / self._vehicle.l_r_m)
        ahead = wrap_angle(course - self._heading_rad)
        self._heading_rad = wrap_angle(self._heading_rad + share * ahead)
        bend = (1.0 - share) * ahead / self._vehicle.l_r_m + glide.bend_per_m / sqrt(1.0 - glide.slope**2)
        return wrap_angle(self._heading_rad + asin(glide.slope)), speed_mps * bend
