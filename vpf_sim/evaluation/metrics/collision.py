"""Collision types and fault, as nuPlan classifies them.

Source: nuplan-devkit, planning/metrics/evaluation_metrics/common/no_ego_at_fault_collisions.py. The first that applies:

    stopped_ego     the ego is stationary (at most 0.05 m/s)
    stopped_track   the other is stationary
    active_rear     the other is behind: its centre more than 150 degrees off the heading, seen from the rear axle
    active_front    the ego's front bumper touches the other
    active_lateral  anything else

The ego is at fault for stopped_track, active_front, and active_lateral if it was not within one lane.

CARLA's driving scores 2.0 and 2.1: route completion reduced by infractions, 0 to 1.

Source: CARLA Autonomous Driving Leaderboard, https://leaderboard.carla.org/evaluation_v2_0/ and evaluation_v2_1. Only
collisions and driving off the road are scored; the other infractions need traffic lights and scripted scenarios.
"""

from collections.abc import Iterable
from math import prod, radians

import numpy as np

from vpf_sim.evaluation.steps import StepTable
from vpf_sim.types import Floats

STOPPED_MPS = 0.05
BEHIND_RAD = radians(150.0)
ROUNDING_M = 0.01
FACTOR_2_0 = {"pedestrian": 0.50, "vehicle": 0.60, "static": 0.65}
WEIGHT_2_1 = {"pedestrian": 1.00, "vehicle": 0.70, "static": 0.60}
CLASS = {"pedestrian": "pedestrian", **dict.fromkeys(("car", "van", "truck", "cyclist"), "vehicle")}


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


def driving_score_2_0(completion: float, kinds_hit: Iterable[str], off_lane_share: float) -> float:
    """completion x product of a factor a collision x (1 - off-lane share)."""
    return completion * prod(FACTOR_2_0[_class(kind)] for kind in kinds_hit) * (1.0 - off_lane_share)


def driving_score_2_1(completion: float, kinds_hit: Iterable[str], off_lane_share: float) -> float:
    """completion x (1 - off-lane share) / (1 + sum of a weight a collision)."""
    return completion * (1.0 - off_lane_share) / (1.0 + sum(WEIGHT_2_1[_class(kind)] for kind in kinds_hit))


def off_lane_share(route_m: Floats, outside: Floats) -> float:
    """Share of the driven distance with a corner of the ego off the carriageway, 0 to 1, from (N,) steps.

    All lanes run one way, so a lane change is no infraction.
    """
    driven = np.abs(np.diff(route_m))
    total = float(np.sum(driven))
    return float(np.sum(driven[outside[:-1] > 0.0])) / total if total > 0.0 else 0.0


def _class(kind: str) -> str:
    return CLASS.get(kind, "static")


def min_clearance_m(clearance_m: Floats) -> float | None:
    """Least distance, m, between the ego and another object; None without objects (all inf)."""
    finite = clearance_m[np.isfinite(clearance_m)]
    return float(np.min(finite)) if len(finite) else None


def min_ttc_s(ttc_s: Floats) -> float | None:
    """Least time to collision, s; None where the ego was never on a collision course."""
    return min_clearance_m(ttc_s)
