"""The Stanley controller: steering by heading error and cross-track error of the front axle.

S. Thrun et al., Stanley: The Robot that Won the DARPA Grand Challenge, J. Field Robotics 23(9), 2006, eq. 10, with the
softening of G. M. Hoffmann et al., Autonomous Automobile Trajectory Tracking for Off-Road Driving, ACC 2007, sec. III.
With psi the path's heading minus the yaw, and e the distance of the path right of the front axle,

    delta = psi + atan(k e / (k_s + v)).

On a circle the front axle has no steady error. From a straight line its error obeys e' = -v sin(atan(k e / (k_s + v))),
and small errors decay as exp(-k v / (k_s + v) t). The original's damping terms model tyres and a servo that the
kinematic car does not have.
"""

from math import atan2, cos, sin

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.controllers.polyline import Polyline
from vpf_sim.driver_interface import Observation
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats, VehicleModel


@settings
class Gains:
    k_per_s: float = setting("Share k of the cross-track error that is corrected in a second.", gt=0.0)
    softening_mps: float = setting("Speed k_s that keeps the steering calm at low speed.", gt=0.0)


def load_gains() -> Gains:
    """The section [stanley] of gains.toml."""
    table = configuration.read("vpf_sim.controllers", "gains.toml")["stanley"]
    return configuration.build(Gains, table, "gains.toml: [stanley]")


class Stanley:
    """Steering along waypoints (M, 2) m."""

    def __init__(self, gains: Gains, route_m: Floats, vehicle: VehicleModel) -> None:
        self._gains = gains
        self._line = Polyline(route_m)
        self._vehicle = vehicle

    def steer(self, observation: Observation) -> float:
        """The steering command in [-1, 1]."""
        axle_x_m = observation.x_m + self._vehicle.l_f_m * cos(observation.yaw_rad)
        axle_y_m = observation.y_m + self._vehicle.l_f_m * sin(observation.yaw_rad)
        right_m, heading_rad = self._line.nearest(axle_x_m, axle_y_m)
        towards_rad = atan2(-self._gains.k_per_s * right_m, self._gains.softening_mps + observation.speed_mps)
        steering_rad = wrap_angle(heading_rad - observation.yaw_rad) + towards_rad
        return min(max(steering_rad / self._vehicle.steering_limit_rad, -1.0), 1.0)
