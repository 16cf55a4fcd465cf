"""Limits of the lateral motion: the shift that is possible before an obstacle, and its speed.

A shift s with the largest lateral acceleration a takes the time sqrt(4.4 s / a) (`PEAK_ACCELERATION`, of least jerk).
On the car's tightest curve, of radius R, a is v^2 / R, so the way v t has a least value that no speed changes,

    t v >= sqrt(4.4 s R),

and the course leaves the road's direction by the mean slope s / way. A large angle needs walking speed. At a steering
rate w the curvature changes by w / (L v) a metre at most, and the least-jerk path with that bound needs the way
(15 s L v / w)^(1/3) (`STEERED`).
"""

from dataclasses import dataclass
from math import inf, sin, tan

import numpy as np

from vpf_sim.planning.lane.frame import Lane
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig
from vpf_sim.planning.lane.steering_unwind import rest
from vpf_sim.types import Bools, Floats, VehicleModel

PEAK_SPEED, PEAK_ACCELERATION = 1.4, 4.4  # of a least-jerk shift D in T: 1.4 D / T and 4.4 D / T^2
STEERED = 15.0  # 15 D / S^3 bounds the jerk, a quarter of what it begins with: it still ends without an overshoot
SLOWEST_MPS = 0.3  # for the rate of the steering: at standstill it turns on no way at all
SPEEDS_MPS: Floats = np.linspace(0.5, 15.0, 30)  # at which the way that a shift needs is looked up
SHARES: Floats = np.linspace(0.0, 1.0, 41)  # of the way of a least-jerk shift,
PROFILE: Floats = SHARES**3 * (10.0 - 15.0 * SHARES + 6.0 * SHARES**2)  # and of the shift that is made on them
MEAN_SLOPE = 1.2  # largest over mean slope of a shift that is in a hurry


def rear_m(lane: Lane, vehicle: VehicleModel) -> float:
    """y of the rear axle, which goes where the car is headed."""
    return lane.y_m + vehicle.l_r_m * sin(lane.heading_rad)


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits at one speed, or at (N,) speeds."""

    ratio: Floats  # largest speed across as a share of the vehicle's
    tightest_per_m: Floats
    steering_per_m2: Floats

    def way(self, shift_m: Floats | float) -> Floats:
        """m of way for a shift from the road's direction and back to it."""
        by_curve = np.sqrt(PEAK_ACCELERATION * shift_m / self.tightest_per_m)
        by_slope = PEAK_SPEED * shift_m / self.ratio
        by_steering = np.cbrt(STEERED * shift_m / self.steering_per_m2)
        way: Floats = np.maximum(np.maximum(by_curve, by_slope), by_steering)
        return way

    def rest(self, slope: float, bend_per_m: float) -> tuple[Floats, Floats]:
        """(N,) m of way until a path can lead along the road, and m across it until then (`steering_unwind`)."""
        return rest(slope, bend_per_m, self.steering_per_m2, self.tightest_per_m)


class KinematicLimits:
    """Limits of the lateral motion of one vehicle."""

    def __init__(self, planner: LanePlannerConfig, vehicle: VehicleModel) -> None:
        config = self._config = planner.limits
        self._vehicle, self._reaction_s, self.walking_mps = vehicle, planner.braking.reaction_s, config.walking_mps
        slip = np.arctan(vehicle.l_r_m / vehicle.wheelbase_m * tan(vehicle.steering_limit_rad))
        # of the tightest curve, with the way that the steering takes to get there
        self.radius_m: float = config.radius_factor * vehicle.l_r_m / sin(slip)
        self._arm_m = inf if config.edge is None else 0.5 * vehicle.length_m + config.edge.turning_m
        # m from the rear axle to where its path must have turned back for the corners to stay on the carriageway
        self.path_arm_m = self._arm_m + vehicle.l_r_m
        self._ratio_speeds = np.array([config.walking_mps, config.fast_mps])
        self._ratios = np.array([config.walking_ratio, config.ratio])
        self.at_speeds = self.limits(SPEEDS_MPS)  # those that are the same in each step

    def ratio(self, speed_mps: Floats | float) -> Floats:
        """Largest speed across as a share of the vehicle's."""
        ratio: Floats = np.asarray(np.interp(speed_mps, self._ratio_speeds, self._ratios))
        return ratio

    def between(self, lane: Lane, speed_mps: float) -> tuple[float, float]:
        """Largest share of lateral speed to the left and right with which the corners stay on the road."""
        most, arm, edge = float(self.ratio(speed_mps)), self._arm_m, self._config.edge
        if edge is None:
            return most, most
        left, right = self._gaps(lane, lane.y_m)
        return min(max(left / arm, edge.least_ratio), most), min(max(right / arm, edge.least_ratio), most)

    def path_between(self, lane: Lane, rear_y_m: float) -> tuple[float, float]:
        """Largest slopes to the left and right of the rear axle's path at a lateral position."""
        if self._config.edge is None:
            return inf, inf
        left, right = self._gaps(lane, rear_y_m)
        return left / self.path_arm_m, right / self.path_arm_m

    def edge_way(self, gap_m: float, left_m: Floats, slope: float) -> Floats:
        """(K,) m of way before obstacles, to come from one gap to an edge to the smaller one that they leave.

        At walking speed the car, headed at a slope towards the edge, turns to its largest angle and comes near by
        `path_between`, g' = -g / arm, until the rear axle is beside the face. inf where no gap is left.
        """
        if self._config.edge is None or gap_m <= 0.0:
            return np.full_like(left_m, -np.inf)
        arm = self.path_arm_m
        steepest = min(gap_m / arm, self._config.walking_ratio)
        turning = 0.5 * self.radius_m * max(steepest - slope, 0.0) ** 2 / steepest
        near = np.minimum(np.maximum(left_m, 0.0), gap_m)
        begins = np.minimum(np.maximum(steepest * arm, near), gap_m)
        with np.errstate(divide="ignore"):
            way: Floats = turning + (gap_m - begins) / steepest + arm * np.log(begins / near)
        return np.where(near < gap_m, way - 0.5 * self._vehicle.length_m - self._vehicle.l_r_m, -np.inf)

    def _gaps(self, lane: Lane, y_m: float) -> tuple[float, float]:
        """m between the car at y and the left and the right edge."""
        half_width = 0.5 * self._vehicle.width_m
        return y_m - lane.left_m - half_width, lane.right_m - y_m - half_width

    def tightest(self, speed_mps: Floats | float) -> Floats:
        """Largest curvature of the path across, 1/m: what is comfortable, or the car's tightest curve."""
        comfortable = self._config.acceleration_mps2 / np.maximum(speed_mps, self._config.walking_mps) ** 2
        return np.minimum(comfortable, 1.0 / self.radius_m)

    def steering(self, speed_mps: Floats | float) -> Floats:
        """Largest change of that curvature along the way, 1/m2: what the steering's rate and comfort leave of it."""
        config, speed = self._config, np.maximum(speed_mps, SLOWEST_MPS)
        by_steering = config.steering_radps / self._vehicle.wheelbase_m / speed
        return np.minimum(by_steering, config.yaw_acceleration_radps2 / speed**2)

    def limits(self, speed_mps: Floats | float) -> Limits:
        """All limits at a speed."""
        return Limits(self.ratio(speed_mps), self.tightest(speed_mps), self.steering(speed_mps))

    def largest_shift(self, way_m: Floats) -> Floats:
        """m, the largest shift on each way at walking speed, from the road's direction and back to it."""
        way = np.maximum(way_m, 0.0)
        turning = way**2 / (PEAK_ACCELERATION * self.radius_m)
        largest: Floats = np.minimum(turning, way * self._config.walking_ratio / MEAN_SLOPE)
        return largest

    def least_way(self, shift_m: Floats) -> Floats:
        """m, the way on which each shift is just possible: the inverse of `aside`."""
        shift = np.maximum(shift_m, 0.0)
        turning = np.sqrt(PEAK_ACCELERATION * self.radius_m * shift)
        least: Floats = np.maximum(turning, shift * MEAN_SLOPE / self._config.walking_ratio)
        return least

    def reaches(self, way_m: Floats, shift_m: Floats, slope: float) -> Bools:
        """(K,) whether shifts are possible at all for a car headed at a slope towards them (`heading_shift`)."""
        reached: Bools = shift_m - self.heading_shift(way_m, slope) <= self.largest_shift(way_m)
        return reached

    def heading_shift(self, way_m: Floats, slope: Floats | float) -> Floats:
        """m aside that a car headed at a slope gets by going straight on until its bumper is there.

        The side at the front must be clear by then, half a length ahead of the pose. The side behind it is farther off,
        unless the car turns back before it is past.
        """
        slope = np.maximum(slope, 0.0)
        way = np.maximum(way_m, 0.0) + 0.5 * self._vehicle.length_m
        wider = 0.5 * self._vehicle.width_m * (np.sqrt(1.0 + slope**2) - 1.0)
        heading_shift: Floats = way * slope - wider
        return heading_shift

    def speed(self, way_m: Floats, shift_m: Floats, goal_m: float, slope: float) -> Floats:
        """(K,) m/s at which shifts are done on the way that is left, on a path to a goal so far aside or farther.

        inf where nothing is left to do, else at least the lowest of `SPEEDS_MPS`. A car headed at a slope towards the
        goal has begun already: on the curve of radius R, R slope of the way and half of R slope^2 of the shift.
        """
        if not (shift_m > 0.0).any():
            return np.full_like(shift_m, np.inf)
        limits = self.at_speeds
        radius = 1.0 / limits.tightest_per_m
        begun = 0.5 * radius * slope**2
        shift = np.maximum(shift_m[:, None] + begun, 0.0)
        whole = np.maximum(goal_m + begun, shift)
        part = np.interp(shift / np.maximum(whole, 1e-6), PROFILE, SHARES)
        waits = 1.0 - np.minimum(slope / limits.ratio, 1.0)  # who turns already has no reaction to wait for
        ways = part * limits.way(whole) - radius * slope + waits * self._reaction_s * SPEEDS_MPS
        needed = np.maximum.accumulate(ways, axis=1)
        speed = np.array([np.interp(*row, SPEEDS_MPS) for row in zip(way_m, needed, strict=True)])
        return np.where(shift_m > 0.0, speed, np.inf)
