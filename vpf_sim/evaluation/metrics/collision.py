"""Collision types and fault, as nuPlan classifies them.

Source: nuplan-devkit, planning/metrics/evaluation_metrics/common/no_ego_at_fault_collisions.py. The first that applies:

    stopped_ego     the ego is stationary (at most 0.05 m/s)
    stopped_track   the other is stationary
    active_rear     the other is behind: its centre more than 150 degrees off the heading, seen from the rear axle
    active_front    the ego's front bumper touches the other
    active_lateral  anything else

The ego is at fault for stopped_track, active_front, and active_lateral if it was not within one lane.
"""

from math import radians

from vpf_sim.evaluation.steps import StepTable

STOPPED_MPS = 0.05
BEHIND_RAD = radians(150.0)
ROUNDING_M = 0.01


def collision_type(table: StepTable) -> str:
    """The type of the collision that ended an episode, from the last row and its nearest object.

    The simulator stops at most one frame before contact, so the bumper touches an object that is no farther than both
    move in a frame.
    """
    ego_mps, other_mps = table.speed_mps[-1], table.near_speed_mps[-1]
    if ego_mps <= STOPPED_MPS:
        return "stopped_ego"
    if other_mps <= STOPPED_MPS:
        return "stopped_track"
    if abs(table.near_bearing_rad[-1]) > BEHIND_RAD:
        return "active_rear"
    frame_s = table.time_s[-1] - table.time_s[-2]
    touches = table.near_bumper_m[-1] <= (ego_mps + other_mps) * frame_s + ROUNDING_M
    return "active_front" if touches else "active_lateral"


def is_at_fault(kind: str, table: StepTable) -> bool:
    """Whether the ego is at fault for a collision of this type."""
    return kind in ("stopped_track", "active_front") or (kind == "active_lateral" and not table.in_lane[-1])
