"""Follows a planned path and its speed: the path's curvature ahead of time, and feedback of the deviations.

With the lateral deviation e and the error of the course h, the curvature is k = k_path - e / l^2 - z h / l, for a
length l that grows with the speed: at constant speed e'' + z v / l e' + (v / l)^2 e = 0, with the damping ratio z / 2.
"""

from math import asin, atan, tan

from vpf_sim.types import Command, TrackingTarget, VehicleModel

LEAST_REACH_M, REACH_S = 2.2, 0.55  # l
DAMPING = 1.8  # z
SPEED_PER_S, PLACE_PER_S2 = 2.0, 0.5
MOST_PLACE_M, PLACE_FROM_MPS = 1.0, 0.5
STANDING_MPS, HOLD_MPS2 = 0.05, -2.0
LARGEST_SLIP = 0.5  # sine of the slip angle


def command(target: TrackingTarget, speed_mps: float, vehicle: VehicleModel) -> Command:
    """Throttle and steering."""
    acceleration = _acceleration(target, speed_mps)
    throttle = acceleration / vehicle.full_mps2(acceleration)
    steering = steering_rad(target, speed_mps, vehicle) / vehicle.steering_limit_rad
    return Command(min(max(throttle, -1.0), 1.0), min(max(steering, -1.0), 1.0))


def steering_rad(target: TrackingTarget, speed_mps: float, vehicle: VehicleModel) -> float:
    """The angle at which a kinematic bicycle's middle has the wanted curvature."""
    reach = max(LEAST_REACH_M, REACH_S * speed_mps)
    feedback = target.lateral_error_m / reach**2 + DAMPING * target.course_error_rad / reach
    sine = (target.curvature_per_m - feedback) * vehicle.l_r_m
    slip = asin(min(max(sine, -LARGEST_SLIP), LARGEST_SLIP))
    return atan(vehicle.wheelbase_m / vehicle.l_r_m * tan(slip))


def _acceleration(target: TrackingTarget, speed_mps: float) -> float:
    """m/s^2; a car that shall stand is held by its brake."""
    if target.speed_mps < STANDING_MPS and target.acceleration_mps2 <= 0.0:
        return HOLD_MPS2
    acceleration = target.acceleration_mps2 + SPEED_PER_S * (target.speed_mps - speed_mps)
    if target.speed_mps > PLACE_FROM_MPS:
        acceleration += PLACE_PER_S2 * min(max(target.behind_m, -MOST_PLACE_M), MOST_PLACE_M)
    return acceleration
