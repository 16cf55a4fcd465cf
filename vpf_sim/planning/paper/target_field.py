"""The target's attraction (paper, section IV-A).

Printed: U_att = 1/2 alpha ||sqrt((x - x_goal)^2 + (y - y_goal)^2)||, F_att = grad U_att with the module alpha r and the
angle theta_goal = atan((y - y_goal) / (x - x_goal)). Module alpha r belongs to U_att = 1/2 alpha r^2, and it is -grad
U_att that leads to the goal.
"""

from math import atan, atan2, cos, hypot, sin
from typing import Literal

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.planning.paper.lane import Lane
from vpf_sim.types import Floats


@settings
class TargetFieldConfig:
    """With `reach_m` the weight against the other fields does not change along the way."""

    alpha: float = setting("Weight alpha of the target field.", gt=0.0)
    direction: Literal["printed", "repaired"] = setting(
        "Direction: `printed`, atan of world coordinates used in vehicle axes, or `repaired`, atan2 in vehicle axes."
    )
    at: Literal["goal", "horizon"] = setting(
        "Target: the goal, or `horizon`, the middle of the preferred lane `reach_m` ahead."
    )
    reach_m: float | None = setting("Largest distance in the modulus; none: as printed.", default=None, gt=0.0)

    def __post_init__(self) -> None:
        if self.at == "horizon" and (self.reach_m is None or self.direction != "repaired"):
            raise ValueError("at: horizon needs reach_m and the repaired direction")


def force(
    x_m: float, y_m: float, yaw_rad: float, goal_m: tuple[float, float], lane: Lane, config: TargetFieldConfig
) -> Floats:
    """(2,) F_att in vehicle axes.

    The printed angle is right in the world for goals ahead along X, since both differences change sign together; it
    turns back for a goal behind, and does not know the vehicle's own yaw.
    """
    ahead, aside = goal_m[0] - x_m, goal_m[1] - y_m
    distance = hypot(ahead, aside)
    module = config.alpha * (distance if config.reach_m is None else min(distance, config.reach_m))
    if config.at == "horizon" and config.reach_m is not None and distance > config.reach_m:
        reach = config.reach_m
        angle = atan2(lane.heading_rad * reach + 0.5 * lane.curvature_per_m * reach**2 - lane.y_m, reach)
    elif config.direction == "repaired":
        angle = atan2(aside, ahead) - yaw_rad
    else:
        angle = atan(aside / ahead) if ahead else atan2(aside, 0.0)
    return np.array([module * cos(angle), module * sin(angle)])
