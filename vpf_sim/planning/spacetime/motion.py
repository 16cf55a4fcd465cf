"""The chosen motion, and why the others were not."""

from dataclasses import dataclass
from math import atan
from typing import NamedTuple

import numpy as np

from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.planning.spacetime.motions import motions
from vpf_sim.scene.road import Road, stretch_at
from vpf_sim.types import Floats, PlanDetails, Reals, VehicleModel


class Rejected(NamedTuple):
    """The number of rejected candidates, each counted for the limit that it breaks most.

    Collisions are counted apart, of the candidates that were compared with the objects.
    """

    acceleration: int = 0
    lateral_acceleration: int = 0
    curvature: int = 0
    steering_rate: int = 0
    road_edge: int = 0
    collision: int = 0


@dataclass(frozen=True, slots=True)
class Motion:
    """A motion of the car's rear axle along the road."""

    time_s: float  # at which it begins
    start: PathState
    path: Paths  # one
    profile: Profiles  # one
    times_s: Reals  # (T,) from its beginning
    cost: float
    rejected: Rejected  # of the other candidates
    is_rejected: bool  # it breaks a limit, as all others do

    def speed_at(self, time_s: float) -> float:
        """m/s along the road."""
        return float(np.interp(time_s - self.time_s, self.times_s, self.profile.speed_mps[0]))

    def acceleration_at(self, time_s: float) -> float:
        """m/s^2 along the road."""
        return float(np.interp(time_s - self.time_s, self.times_s, self.profile.acceleration_mps2[0]))

    def s_at(self, time_s: float) -> float:
        """m along the road."""
        travelled = np.interp(time_s - self.time_s, self.times_s, self.profile.travelled_m[0])
        return self.start.s_m + float(travelled)

    def path_at(self, s_m: float) -> tuple[float, float, float]:
        """d m, d d / d s and d^2 d / d s^2 /m at s."""
        d, slope, bend = self.path.at(np.array([s_m]))
        return float(d[0]), float(slope[0]), float(bend[0])

    def course_at(self, road: Road, s_m: float) -> float:
        """rad, of the path at s from the road's direction."""
        d, slope, _ = self.path_at(s_m)
        return atan(slope / stretch_at(road.direction_at(s_m)[1], d))


@dataclass(frozen=True, slots=True)
class MotionPlan(PlanDetails):
    """The motion that is driven, for the record of a frame and the overlay."""

    motion: Motion
    road: Road
    vehicle: VehicleModel
    pose: Floats  # (3,) x m, y m, yaw rad of the car now

    @property
    def shift_m(self) -> float:
        """To the right, from where the motion begins to where its path ends."""
        return float(self.motion.path.end_m[0]) - self.motion.start.d_m

    def points_m(self) -> Floats:
        """(T, 2) places of the car's middle in vehicle axes, at the motion's times."""
        one = self.motion
        driven = motions(self.road, one.start, one.path, one.profile, self.vehicle)
        x, y, _ = (driven.in_time(values)[0, 0] for values in driven.poses)
        x, y = driven.origin_m[0] + x, driven.origin_m[1] + y
        x, y, yaw = x - self.pose[0], y - self.pose[1], self.pose[2]
        return np.stack([np.cos(yaw) * x + np.sin(yaw) * y, np.cos(yaw) * y - np.sin(yaw) * x], axis=-1)
