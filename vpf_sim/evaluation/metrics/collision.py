"""Whose fault a collision was, as nuPlan classifies it.

Source: nuplan-devkit, planning/metrics/evaluation_metrics/common/no_ego_at_fault_collisions.py. In this order:

    stopped_ego     the ego stands (at most 0.05 m/s)
    stopped_track   the other stands
    active_rear     the other is behind: its centre more than 150 degrees off the heading, seen from the rear axle
    active_front    the ego's front bumper touches the other
    active_lateral  anything else

At fault are stopped_track and active_front, and active_lateral if the ego was not in one lane of the road.
"""

from math import radians

from vpf_sim.evaluation.steps import StepTable

STOPPED_MPS = 0.05
BEHIND_RAD = radians(150.0)
ROUNDING_M = 0.01


def collision_type(table: StepTable) -> str:
    """The class of the collision in which an episode ended, from its last row and the nearest body there.

    The simulator stops at the latest one frame before two bodies would touch, so the bumper touches what is no farther
    than both move in a frame.
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
    """Whether the ego could have prevented a collision of this class by driving otherwise."""
    return kind in ("stopped_track", "active_front") or (kind == "active_lateral" and not table.in_lane[-1])
