"""From the field's minimum to heading and speed: how the robust variant moves across the lane.

The minimum jumps when a body appears; the reference y_r glides after it with bounded speed, acceleration and jerk. The
course that the centre of mass shall take, with psi_r the road's direction, is

    chi_d = psi_r + asin((dy_r / dt + k (y_r - y)) / v).

A bicycle's centre of mass moves at yaw + slip, and d psi / dt = v sin(slip) / l_r, so its yaw is its course through a
lag of l_r / v: l_r / v d psi / dt = chi - psi. The heading reference is the desired course through that very lag, exact
for the steering that follows it. It carries the slip of a bend (l_r / R) and the lever arm of a swerve, and its rate
(chi_d - psi_d) v / l_r needs no differentiation (METHOD A13, A17).

What that and the speed by what is ahead are worth is seen without them: with `motion = "direct"` y_r is the minimum
itself and psi_d the course, and with `speed = "constant"` v_d stays the reference speed, as in the paper.
"""

from dataclasses import dataclass
from math import asin, exp, sqrt, tan
from typing import Literal

import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.lane import Lane, LaneObstacles
from vpf_sim.planning.lane_field import LaneField
from vpf_sim.planning.reach import PEAK_ACCELERATION, PEAK_SPEED, Reach
from vpf_sim.types import Floats, Reference, VehicleModel

SHORTEST_S = 0.8  # of a shift
SLOWEST_CLOSING_MPS = 0.5
STANDING_MPS = 0.1


@dataclass(frozen=True, slots=True)
class LaneReferenceConfig:
    """Limits of the reference's own motion across the lane, and of the speed."""

    speed_mps: float  # largest speed across
    shift_s: float  # duration of a shift when there is time
    shift_share: float  # and otherwise its share of the time that is left
    correction_per_s: float  # k
    correction_per_m: float  # k / v at most: the slower, the longer the car takes to turn
    correction_mps: float  # largest speed of the correction
    correction_ratio: float  # and its largest share of the vehicle's speed
    lead_m: float  # y_r stays this near to the vehicle's own y
    minimum_clearance_m: float  # nearer than this counts as blocked
    walking_clearance_m: float  # the same at walking speed
    bend_acceleration_mps2: float  # lateral, limits the speed in bends
    brake_mps2: float  # of a stop before a blocked road
    rise_mps2: float  # of the speed reference, afterwards
    standoff_m: float  # free road kept when stopping
    time_gap_s: float  # kept besides to a body that moves
    standing_s: float  # after which the car creeps up to a body that blocks it,
    creep_mps: float  # at this speed
    creep_standoff_m: float  # and to this distance
    motion: Literal["direct", "least_jerk"] = "least_jerk"
    speed: Literal["constant", "ahead"] = "ahead"

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if name not in ("motion", "speed") and not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: expected > 0, got {getattr(self, name)}")


class LaneReference:
    """The reference's place, speed and acceleration across the lane, and the lagged heading."""

    def __init__(
        self,
        config: LaneReferenceConfig,
        vehicle: VehicleModel,
        speed_reference_mps: float,
        rate_hz: float,
        reach: Reach,
    ) -> None:
        self._config = config
        self._vehicle = vehicle
        self._speed_reference_mps = speed_reference_mps
        self._dt_s = 1.0 / rate_hz
        self.y_m: float | None = None
        self._rate_mps = 0.0
        self._acceleration_mps2 = 0.0
        self._shift_s = config.shift_s
        self._heading_rad: float | None = None
        self._wanted_mps: float | None = None
        self._stood_s = 0.0
        self._reach = reach

    def update(
        self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float, yaw_rad: float, speed_mps: float
    ) -> Reference:
        """One step of 1 / rate_hz towards the field's minimum."""
        if self.y_m is None:
            self._rate_mps = 0.0
            self.y_m = lane.y_m
        if self._config.motion == "direct":
            self.y_m = minimum_m
        else:
            self._glide(minimum_m, self._time_left(obstacles, field, speed_mps), speed_mps)
            self.y_m = min(max(self.y_m, lane.y_m - self._config.lead_m), lane.y_m + self._config.lead_m)
        heading, rate = self._heading(lane, yaw_rad, speed_mps)
        wanted = self._speed(lane, obstacles, field, minimum_m, speed_mps)
        return Reference(heading, self._risen(wanted, speed_mps), rate)

    def _risen(self, wanted_mps: float, speed_mps: float) -> float:
        """v_d, which falls at once and rises gently: what was braked for may be gone from one frame to the next."""
        if self._config.speed == "ahead" and self._wanted_mps is not None:
            rise = self._config.rise_mps2 * self._dt_s
            wanted_mps = min(wanted_mps, max(self._wanted_mps, speed_mps) + rise)
        self._wanted_mps = wanted_mps
        return wanted_mps

    def _time_left(self, obstacles: LaneObstacles, field: LaneField, speed_mps: float) -> float:
        """s until the first body is reached that stands where y_r is now."""
        clearance = self._config.minimum_clearance_m
        assert self.y_m is not None
        if not len(obstacles):
            return np.inf
        way = field.bumper(obstacles)
        hit = (field.overlap(obstacles, self.y_m, clearance) > 0.0) & (way > 0.0)
        closing = np.maximum(max(speed_mps, 1.0) - obstacles.speed_mps, SLOWEST_CLOSING_MPS)
        return float(np.min(way / closing, where=hit, initial=np.inf))

    def _glide(self, minimum_m: float, time_s: float, speed_mps: float) -> None:
        """Move y_r towards the minimum with the least jerk that is there in T, T receding.

        The least-jerk path from place y, speed w, acceleration a to rest at y_m in T begins with the jerk
        60 (y_m - y) / T^3 - 36 w / T^2 - 9 a / T. For a constant T that is a filter of third order; after a step D it
        is done in 1.1 T, with an overshoot of 2 %, a largest speed of 1.4 D / T, a largest acceleration of 4.4 D / T^2.
        """
        config, dt = self._config, self._dt_s
        assert self.y_m is not None
        error = minimum_m - self.y_m
        fastest = min(config.speed_mps, self._reach.ratio(speed_mps) * max(speed_mps, 1.0))
        least = max(
            sqrt(PEAK_ACCELERATION * abs(error) / self._reach.acceleration(speed_mps)),
            PEAK_SPEED * abs(error) / fastest,
        )
        wanted = min(config.shift_s, config.shift_share * time_s)
        # A hurry ends slowly: a longer T at full speed would carry the reference past the minimum.
        self._shift_s = max(least, min(wanted, self._shift_s + dt), SHORTEST_S)
        horizon = self._shift_s
        jerk = (60.0 * error / horizon - 36.0 * self._rate_mps) / horizon**2 - 9.0 * self._acceleration_mps2 / horizon
        self._acceleration_mps2 += jerk * dt
        self._rate_mps += self._acceleration_mps2 * dt
        self.y_m += self._rate_mps * dt

    def _heading(self, lane: Lane, yaw_rad: float, speed_mps: float) -> tuple[float, float | None]:
        """psi_d rad and its rate rad/s, if it is known."""
        config = self._config
        assert self.y_m is not None
        pull = min(config.correction_per_s, config.correction_per_m * speed_mps) * (self.y_m - lane.y_m)
        most = min(config.correction_mps, config.correction_ratio * speed_mps)
        across = self._rate_mps + min(max(pull, -most), most)
        left, right = self._reach.between(lane, speed_mps)
        ratio = min(max(across / max(speed_mps, 1.0), -left), right)
        course = yaw_rad + lane.heading_rad + asin(ratio)
        if config.motion == "direct":
            return wrap_angle(course), None
        if self._heading_rad is None:
            self._heading_rad = yaw_rad
        share = 1.0 - exp(-speed_mps * self._dt_s / self._vehicle.l_r_m)
        ahead = wrap_angle(course - self._heading_rad)
        self._heading_rad = wrap_angle(self._heading_rad + share * ahead)
        return self._heading_rad, (1.0 - share) * ahead * speed_mps / self._vehicle.l_r_m

    def _speed(
        self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float, speed_mps: float
    ) -> float:
        """v_d: the reference speed, less in tight bends and before bodies that cannot be cleared in time."""
        config = self._config
        limit = self._speed_reference_mps
        if config.speed == "constant":
            return limit
        bend = abs(lane.curvature_per_m)
        if bend > 0.0:
            limit = min(limit, sqrt(config.bend_acceleration_mps2 / bend))
        if not len(obstacles):
            return limit
        way = field.bumper(obstacles)
        moves = obstacles.speed_mps > 0.0
        present = ((field.present(obstacles) > 0.0) | moves) & (way > 0.0)
        clearance = config.minimum_clearance_m if speed_mps > self._reach.walking_mps else config.walking_clearance_m
        blocked = present & (field.overlap(obstacles, minimum_m, clearance) > 0.0)
        spare = way - config.standoff_m - config.time_gap_s * obstacles.speed_mps
        follow = obstacles.speed_mps * np.clip(1.0 + spare / (config.standoff_m + way), 0.0, 1.0)
        stop = follow + np.sqrt(2.0 * config.brake_mps2 * np.maximum(spare, 0.0))
        there = self._before(lane, obstacles, field, minimum_m)
        limits = np.where(blocked, stop, there)
        if self._creeps(speed_mps):
            creep = np.where(way > config.creep_standoff_m, config.creep_mps, 0.0)
            limits = np.where(obstacles.speed_mps > 0.0, limits, np.maximum(limits, creep))
        return float(np.min(limits, where=present, initial=limit))

    def _creeps(self, speed_mps: float) -> bool:
        """Whether the car, having stood for a while, walks up to what blocks it: standing, a camera sees no flow."""
        if speed_mps < STANDING_MPS:
            self._stood_s += self._dt_s
        elif speed_mps > self._reach.walking_mps:
            self._stood_s = 0.0
        return self._stood_s > self._config.standing_s

    def _before(self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float) -> Floats:
        """(K,) m/s before bodies that the minimum avoids, but the car not yet: be there only when the shift is done.

        Where it cannot be done as wide as wanted, walking; where not at all, the car stops, as early as it can.
        """
        config, way = self._config, field.bumper(obstacles)
        slope = -float(np.sign(minimum_m - lane.y_m)) * tan(lane.heading_rad)
        wanted = field.shift(obstacles, lane.y_m, minimum_m, config.minimum_clearance_m)
        needed = field.shift(obstacles, lane.y_m, minimum_m, config.walking_clearance_m)
        there = np.maximum(self._reach.speed(way, wanted, slope), self._reach.walking_mps)
        there = np.where(self._reach.speed(way, needed, slope) > 0.0, there, 0.0)
        return obstacles.speed_mps + there
