"""The target's attraction (paper, section IV-A).

Printed: U_att = 1/2 alpha ||sqrt((x - x_goal)^2 + (y - y_goal)^2)||, F_att = grad U_att with the module alpha r and the
angle theta_goal = atan((y - y_goal) / (x - x_goal)). Module alpha r belongs to U_att = 1/2 alpha r^2, and it is -grad
U_att that leads to the goal (METHOD A8).
"""

from dataclasses import dataclass
from math import atan, atan2, cos, hypot, sin
from typing import Literal

import numpy as np

from vpf_sim.types import Floats


@dataclass(frozen=True, slots=True)
class TargetFieldConfig:
    """`printed`: atan, an angle of the world taken for one of the vehicle; `repaired`: atan2, in vehicle axes."""

    alpha: float
    direction: Literal["printed", "repaired"]

    def __post_init__(self) -> None:
        if not self.alpha > 0.0:
            raise ValueError(f"alpha: expected > 0, got {self.alpha}")


def force(x_m: float, y_m: float, yaw_rad: float, goal_m: tuple[float, float], config: TargetFieldConfig) -> Floats:
    """(2,) F_att in vehicle axes.

    The printed angle is right in the world for goals ahead along X, since both differences change sign together; it
    turns back for a goal behind, and does not know the vehicle's own yaw.
    """
    ahead, aside = goal_m[0] - x_m, goal_m[1] - y_m
    module = config.alpha * hypot(ahead, aside)
    if config.direction == "repaired":
        angle = atan2(aside, ahead) - yaw_rad
    else:
        angle = atan(aside / ahead) if ahead else atan2(aside, 0.0)
    return np.array([module * cos(angle), module * sin(angle)])
