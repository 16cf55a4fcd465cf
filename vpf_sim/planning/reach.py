"""How far aside the car gets on the way that is left before a body, and at what speed.

A shift s across the road with a largest lateral acceleration a takes the time sqrt(4.4 s / a) (`PEAK_ACCELERATION`, of
least jerk). Slowing down does not help for ever: on the car's tightest curve, of radius R, a is v^2 / R, so the way v t
has a least value that no speed changes,

    t v >= sqrt(4.4 s R),

and on it the course leaves the road's direction by as much as the mean slope s / way asks. A wide angle is for walking
speed alone. What the car's heading brings by itself until then is no shift that is left to be made.
"""

from dataclasses import dataclass
from math import sin, tan

import numpy as np

from vpf_sim.planning.lane import Lane
from vpf_sim.types import Floats, VehicleModel

PEAK_SPEED, PEAK_ACCELERATION = 1.4, 4.4  # of a least-jerk shift D in T: 1.4 D / T and 4.4 D / T^2
REACTION_S = 0.3  # until the steering shows across the lane
EASE = 1.35  # of the tightest curve: the steering takes time to get there
TURNING_M = 2.5  # of way until a corner turns back from the edge
LEAST_RATIO = 0.05  # where there is no room at all
MEAN_SLOPE = 1.2  # largest over mean slope of a shift that is in a hurry


@dataclass(frozen=True, slots=True)
class ReachConfig:
    """Limits of going aside; a ratio is the largest speed across as a share of the vehicle's."""

    ratio: float  # at speed
    walking_ratio: float  # when walking
    walking_mps: float
    fast_mps: float  # from here on it is `ratio`
    acceleration_mps2: float  # largest across

    def __post_init__(self) -> None:
        if not 0.0 < self.ratio <= self.walking_ratio < 1.0:
            raise ValueError(f"ratio, walking_ratio: expected 0 < ratio <= walking_ratio < 1, got {self}")
        if not 0.0 < self.walking_mps < self.fast_mps:
            raise ValueError(f"walking_mps: expected 0 < walking_mps < fast_mps, got {self}")
        if not self.acceleration_mps2 > 0.0:
            raise ValueError(f"acceleration_mps2: expected > 0, got {self.acceleration_mps2}")


class Reach:
    """The geometry of going aside for one vehicle."""

    def __init__(self, config: ReachConfig, vehicle: VehicleModel) -> None:
        self._config = config
        self._vehicle = vehicle
        slip = np.arctan(vehicle.l_r_m / vehicle.wheelbase_m * tan(vehicle.steering_limit_rad))
        self._radius_m = EASE * vehicle.l_r_m / sin(slip)

    @property
    def walking_mps(self) -> float:
        return self._config.walking_mps

    def ratio(self, speed_mps: float) -> float:
        """Largest speed across as a share of the vehicle's."""
        config = self._config
        speeds, ratios = (config.walking_mps, config.fast_mps), (config.walking_ratio, config.ratio)
        return float(np.interp(speed_mps, speeds, ratios))

    def between(self, lane: Lane, speed_mps: float) -> tuple[float, float]:
        """The same to the left and to the right: no more than leaves the corners of our body on the carriageway."""
        most, arm = self.ratio(speed_mps), 0.5 * self._vehicle.length_m + TURNING_M
        left = lane.y_m - lane.left_m - 0.5 * self._vehicle.width_m
        right = lane.right_m - lane.y_m - 0.5 * self._vehicle.width_m
        return min(max(left / arm, LEAST_RATIO), most), min(max(right / arm, LEAST_RATIO), most)

    def acceleration(self, speed_mps: float) -> float:
        """Largest acceleration across, m/s2: what is comfortable, or less where the car cannot turn so tightly."""
        return min(self._config.acceleration_mps2, max(speed_mps, self._config.walking_mps) ** 2 / self._radius_m)

    def aside(self, way_m: Floats) -> Floats:
        """m, the largest shift on each way at walking speed, from the road's direction and back to it."""
        way = np.maximum(way_m, 0.0)
        turning = way**2 / (PEAK_ACCELERATION * self._radius_m)
        aside: Floats = np.minimum(turning, way * self._config.walking_ratio / MEAN_SLOPE)
        return aside

    def speed(self, way_m: Floats, shift_m: Floats, slope: float) -> Floats:
        """(K,) m/s at which shifts are made on the way that is left, the car being headed at a slope towards them.

        0 where no speed is low enough, inf where nothing is left to do.
        """
        config, way = self._config, np.maximum(way_m, 1e-3)
        left = np.maximum(shift_m - way * max(slope, 0.0), 0.0)
        by_time = way / (np.sqrt(PEAK_ACCELERATION * left / self._config.acceleration_mps2) + REACTION_S)
        steepness = MEAN_SLOPE * np.maximum(shift_m, 0.0) / way
        ratios, speeds = (config.ratio, config.walking_ratio), (config.fast_mps, config.walking_mps)
        by_slope = np.where(steepness <= config.ratio, np.inf, np.interp(steepness, ratios, speeds))
        speed = np.where(left <= self.aside(way), np.minimum(by_time, by_slope), 0.0)
        return np.where(shift_m > 0.0, speed, np.inf)
