"""The reference of the controller: the gradient line to the chosen motion, and its speed.

The reference heading is that of the path, turned towards it by atan(e / l) for the lateral deviation e and a length l
that grows with the speed; its rate is the derivative in closed form.
"""

from math import atan, sin

from vpf_sim.driver_interface import Observation
from vpf_sim.planning.spacetime.motion import Motion
from vpf_sim.planning.spacetime.motions import path_curvature, rear_axle, rear_speed
from vpf_sim.scene.road import Road, stretch_at
from vpf_sim.types import Reference, VehicleModel

LEAST_REACH_M, REACH_S = 2.2, 0.7  # l
STEERING_S, LEAST_AHEAD_M = 0.15, 0.3  # how far ahead the path's curvature is read
PEDALS_S = 0.05
PLACE_PER_S, MOST_PLACE_M, PLACE_FROM_MPS = 0.2, 1.0, 0.5
STANDING_MPS, HOLD_MPS = 0.05, -0.5  # a reference below 0 holds the car by its brake


def reference(
    motion: Motion, road: Road, observation: Observation, place_m: tuple[float, float], vehicle: VehicleModel
) -> Reference:
    """The reference at an observation's time, for the car with its middle at (s, d)."""
    s, d, angle = rear_axle(road, *place_m, observation.yaw_rad, vehicle)
    off = d - motion.path_at(s)[0]
    error = angle - motion.course_at(road, s)
    speed = rear_speed(observation.speed_mps, observation.yaw_rate_radps, vehicle)
    reach = max(LEAST_REACH_M, REACH_S * speed)
    turning = speed * sin(error) * reach / (reach**2 + off**2)  # of atan(e / l), rad/s
    curvature = _curvature(motion, road, s + max(STEERING_S * speed, LEAST_AHEAD_M))
    return Reference(
        heading_rad=observation.yaw_rad - error - atan(off / reach),
        speed_mps=_speed(motion, observation.time_s, s),
        heading_rate_radps=speed * curvature - turning,
        acceleration_mps2=motion.acceleration_at(observation.time_s + PEDALS_S),
    )


def _speed(motion: Motion, time_s: float, s_m: float) -> float:
    """m/s: the motion's, and a little more where the car is behind its planned place."""
    speed = motion.speed_at(time_s + PEDALS_S)
    if speed < STANDING_MPS and motion.acceleration_at(time_s + PEDALS_S) <= 0.0:
        return HOLD_MPS
    if speed <= PLACE_FROM_MPS:
        return speed
    return speed + PLACE_PER_S * min(max(motion.s_at(time_s) - s_m, -MOST_PLACE_M), MOST_PLACE_M)


def _curvature(motion: Motion, road: Road, s_m: float) -> float:
    """1/m, of the motion's path in the world at s."""
    d, slope, second = motion.path_at(s_m)
    bend = road.direction_at(s_m)[1]
    stretch = stretch_at(bend, d)
    return path_curvature(slope / stretch, second, bend, stretch)
