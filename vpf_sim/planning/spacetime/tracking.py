"""What the controller has to do to follow the chosen motion."""

from math import atan

from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.spacetime.motion import Motion
from vpf_sim.planning.spacetime.motions import LEAST_STRETCH, path_curvature
from vpf_sim.planning.spacetime.planner import slip_rad
from vpf_sim.scene.road import Road
from vpf_sim.types import Observation, TrackingTarget, VehicleModel

STEERING_S, LEAST_AHEAD_M = 0.15, 0.3  # how far ahead the path's curvature is read
PEDALS_S = 0.05


def target(
    motion: Motion, road: Road, observation: Observation, place_m: tuple[float, float], vehicle: VehicleModel
) -> TrackingTarget:
    """The target at an observation's time, for the car at (s, d)."""
    s, d = place_m
    heading, bend = road.direction_at(s)
    planned, slope, _ = motion.path_at(s)
    course = heading + atan(slope / max(1.0 - bend * planned, LEAST_STRETCH))
    own = observation.yaw_rad + slip_rad(observation.speed_mps, observation.yaw_rate_radps, vehicle)
    ahead = s + max(STEERING_S * observation.speed_mps, LEAST_AHEAD_M)
    now_s = observation.time_s
    return TrackingTarget(
        lateral_error_m=d - planned,
        course_error_rad=wrap_angle(own - course),
        curvature_per_m=_curvature(motion, road, ahead),
        speed_mps=motion.speed_at(now_s + PEDALS_S),
        acceleration_mps2=motion.acceleration_at(now_s + PEDALS_S),
        behind_m=motion.s_at(now_s) - s,
    )


def _curvature(motion: Motion, road: Road, s_m: float) -> float:
    """1/m, of the motion's path in the world at s."""
    d, slope, second = motion.path_at(s_m)
    bend = road.direction_at(s_m)[1]
    return path_curvature(slope, second, bend, max(1.0 - bend * d, LEAST_STRETCH))
