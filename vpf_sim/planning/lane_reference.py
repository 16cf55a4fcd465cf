"""From the field's minimum to heading and speed: how the robust variant moves across the lane.

The minimum jumps when a body appears; the reference y_r glides after it with bounded speed, acceleration and jerk. The
course that the centre of mass shall take, with psi_r the road's direction, is

    chi_d = psi_r + asin((dy_r / dt + k (y_r - y)) / v).

A bicycle's centre of mass moves at yaw + slip, and d psi / dt = v sin(slip) / l_r, so its yaw is its course through a
lag of l_r / v: l_r / v d psi / dt = chi - psi. The heading reference is the desired course through that very lag, exact
for the steering that follows it. It carries the slip of a bend (l_r / R) and the lever arm of a swerve, and its rate
(chi_d - psi_d) v / l_r needs no differentiation (METHOD A13, A17).
"""

from dataclasses import dataclass
from math import asin, copysign, exp, sqrt

import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.lane import Lane, LaneObstacles
from vpf_sim.planning.lane_field import LaneField
from vpf_sim.types import Reference, VehicleModel


@dataclass(frozen=True, slots=True)
class LaneReferenceConfig:
    """Limits of the reference's own motion across the lane, and of the speed."""

    speed_mps: float  # largest speed across
    speed_ratio: float  # and its largest share of the vehicle's speed
    acceleration_mps2: float  # across, when there is time
    urgent_acceleration_mps2: float  # and when there is not
    jerk_mps3: float
    settle_s: float  # time constant of the last part of the way
    correction_per_s: float  # k
    correction_mps: float  # largest speed of the correction
    lead_m: float  # y_r stays this near to the vehicle's own y
    minimum_clearance_m: float  # nearer than this counts as blocked
    bend_acceleration_mps2: float  # lateral, limits the speed in bends
    brake_mps2: float  # of a stop before a blocked road
    standoff_m: float  # free road kept when stopping

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: expected > 0, got {getattr(self, name)}")


class LaneReference:
    """The reference's place, speed and acceleration across the lane, and the lagged heading."""

    def __init__(
        self, config: LaneReferenceConfig, vehicle: VehicleModel, speed_reference_mps: float, rate_hz: float
    ) -> None:
        self._config = config
        self._vehicle = vehicle
        self._speed_reference_mps = speed_reference_mps
        self._dt_s = 1.0 / rate_hz
        self.y_m: float | None = None
        self._rate_mps = 0.0
        self._acceleration_mps2 = 0.0
        self._heading_rad: float | None = None

    def update(
        self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float, yaw_rad: float, speed_mps: float
    ) -> Reference:
        """One step of 1 / rate_hz towards the field's minimum."""
        if self.y_m is None:
            self._rate_mps = 0.0
            self.y_m = lane.y_m
        time_s = self._time_left(obstacles, field, speed_mps)
        self._glide(minimum_m, time_s, speed_mps)
        self.y_m = min(max(self.y_m, lane.y_m - self._config.lead_m), lane.y_m + self._config.lead_m)
        heading, rate = self._heading(lane, yaw_rad, speed_mps)
        return Reference(heading, self._speed(lane, obstacles, field, minimum_m), rate)

    def _time_left(self, obstacles: LaneObstacles, field: LaneField, speed_mps: float) -> float:
        """s until the first body is reached that stands where y_r is now."""
        clearance = self._config.minimum_clearance_m
        assert self.y_m is not None
        if not len(obstacles):
            return np.inf
        way = field.bumper(obstacles)
        hit = (field.overlap(obstacles, self.y_m, clearance) > 0.0) & (way > 0.0)
        return float(np.min(way, where=hit, initial=np.inf)) / max(speed_mps, 1.0)

    def _glide(self, minimum_m: float, time_s: float, speed_mps: float) -> None:
        """Move y_r towards the minimum, along the curve from which it can still stop there."""
        config, dt = self._config, self._dt_s
        assert self.y_m is not None
        error = minimum_m - self.y_m
        # A shift by D in T under a constant acceleration, there and back, needs 4 D / T^2.
        needed = 4.0 * abs(error) / max(time_s - 0.3, 0.3) ** 2
        limit = min(max(needed, config.acceleration_mps2), config.urgent_acceleration_mps2)
        fastest = min(config.speed_mps, config.speed_ratio * speed_mps)
        wish = copysign(min(fastest, sqrt(1.4 * limit * abs(error)), abs(error) / config.settle_s), error)
        wanted = min(max((wish - self._rate_mps) / 0.15, -limit), limit)
        step = config.jerk_mps3 * dt
        self._acceleration_mps2 += min(max(wanted - self._acceleration_mps2, -step), step)
        self._rate_mps += self._acceleration_mps2 * dt
        self.y_m += self._rate_mps * dt

    def _heading(self, lane: Lane, yaw_rad: float, speed_mps: float) -> tuple[float, float]:
        """psi_d rad and its rate rad/s."""
        config = self._config
        assert self.y_m is not None
        pull = config.correction_per_s * (self.y_m - lane.y_m)
        across = self._rate_mps + min(max(pull, -config.correction_mps), config.correction_mps)
        ratio = min(max(across / max(speed_mps, 1.0), -config.speed_ratio), config.speed_ratio)
        course = yaw_rad + lane.heading_rad + asin(ratio)
        if self._heading_rad is None:
            self._heading_rad = yaw_rad
        share = 1.0 - exp(-speed_mps * self._dt_s / self._vehicle.l_r_m)
        ahead = wrap_angle(course - self._heading_rad)
        self._heading_rad = wrap_angle(self._heading_rad + share * ahead)
        return self._heading_rad, (1.0 - share) * ahead * speed_mps / self._vehicle.l_r_m

    def _speed(self, lane: Lane, obstacles: LaneObstacles, field: LaneField, minimum_m: float) -> float:
        """v_d: the reference speed, less in tight bends and before bodies that cannot be cleared in time."""
        config = self._config
        assert self.y_m is not None
        limit = self._speed_reference_mps
        bend = abs(lane.curvature_per_m)
        if bend > 0.0:
            limit = min(limit, sqrt(config.bend_acceleration_mps2 / bend))
        if not len(obstacles):
            return limit
        present = (field.present(obstacles) > 0.0) & (obstacles.along_m > 0.0)
        way = np.maximum(field.bumper(obstacles) - config.standoff_m, 0.0)
        clearance = config.minimum_clearance_m
        blocked = present & (field.overlap(obstacles, minimum_m, clearance) > 0.0)
        stop = np.sqrt(2.0 * config.brake_mps2 * way)
        limit = float(np.min(stop, where=blocked, initial=limit))
        # A body that the minimum avoids, but y_r not yet: be there only when the shift is done.
        shift = np.maximum(field.overlap(obstacles, self.y_m, clearance), 0.0)
        pending = present & ~blocked & (shift > 0.0)
        time_s = 2.0 * np.sqrt(shift / config.urgent_acceleration_mps2) + 0.3
        return float(np.min(np.maximum(way / time_s, stop * 0.5), where=pending, initial=limit))
