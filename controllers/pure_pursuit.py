"""Pure pursuit: steer the rear axle on an arc through a look-ahead point of the path.

R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, CMU-RI-TR-92-01, 1992. With the goal point
(x, y) in vehicle axes at the rear axle (y to the right), l^2 = x^2 + y^2 and the wheelbase L, the arc has

    curvature = 2 y / l^2,    steering delta = atan(L curvature).

On a circle the rear axle has no error. A small offset y from a straight line obeys y'' + (2 / l) y' + (2 / l^2) y = 0
over the distance s: it decays as exp(-s / l), with a damping ratio of 1 / sqrt(2).
"""

from math import atan, cos, sin

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.controllers.polyline import Polyline
from vpf_sim.driver_interface import Observation
from vpf_sim.types import Floats, VehicleModel


@settings
class Gains:
    look_ahead_m: float = setting("Distance l from the rear axle to the goal point.", gt=0.0)


def load_gains() -> Gains:
    """The section [pure_pursuit] of gains.toml."""
    table = configuration.read("vpf_sim.controllers", "gains.toml")["pure_pursuit"]
    return configuration.build(Gains, table, "gains.toml: [pure_pursuit]")


class PurePursuit:
    """Steering along waypoints (M, 2) m."""

    def __init__(self, gains: Gains, route_m: Floats, vehicle: VehicleModel) -> None:
        self._gains = gains
        self._line = Polyline(route_m)
        self._vehicle = vehicle

    def steer(self, observation: Observation) -> float:
        """The steering command in [-1, 1]."""
        cosine, sine = cos(observation.yaw_rad), sin(observation.yaw_rad)
        x_m, y_m = observation.x_m - self._vehicle.l_r_m * cosine, observation.y_m - self._vehicle.l_r_m * sine
        goal_x_m, goal_y_m = self._line.ahead(x_m, y_m, self._gains.look_ahead_m)
        dx, dy = goal_x_m - x_m, goal_y_m - y_m
        curvature_per_m = 2.0 * (cosine * dy - sine * dx) / max(dx**2 + dy**2, 1e-6)
        steering_rad = atan(self._vehicle.wheelbase_m * curvature_per_m)
        return min(max(steering_rad / self._vehicle.steering_limit_rad, -1.0), 1.0)
