"""The limits of how the robust variant moves across the lane, and of its speed."""

from dataclasses import dataclass
from typing import Literal


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
    lead_m: float  # y_r stays this near to the rear axle's own y
    minimum_clearance_m: float  # passed so near at full speed
    walking_clearance_m: float  # and so near walking; nearer is blocked
    bend_acceleration_mps2: float  # lateral, limits the speed in bends
    brake_mps2: float  # of a stop before a blocked road
    rise_mps2: float  # of the speed reference, afterwards
    standoff_m: float  # free road kept when stopping,
    far_standoff_m: float  # and at most, where that keeps a way aside open
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
        if not self.walking_clearance_m < self.minimum_clearance_m:
            raise ValueError(
                f"walking_clearance_m: expected < minimum_clearance_m = {self.minimum_clearance_m}, "
                f"got {self.walking_clearance_m}"
            )
        if not self.creep_standoff_m <= self.standoff_m <= self.far_standoff_m:
            raise ValueError(
                "standoff_m: expected creep_standoff_m <= standoff_m <= far_standoff_m, "
                f"got {self.creep_standoff_m}, {self.standoff_m}, {self.far_standoff_m}"
            )
