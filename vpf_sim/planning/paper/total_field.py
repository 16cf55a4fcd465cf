"""The sum of the fields and its direction in the world (paper, section V).

    F_XT = F_att_x - F_rep_x - lambda_X F_X,    F_YT = F_att_y - F_rep_y - lambda_Y F_Y

F_X, F_Y there are the road's F_rep_rd. Image x (right) is summed with the vehicle's X (forward) in print; it belongs on
Y, and what the image says of time belongs on X.
"""

from typing import Literal

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.geometry import rotation
from vpf_sim.types import Floats, Force


@settings
class TotalFieldConfig:
    """How the forces are summed and turned into the world."""

    axes: Literal["printed", "mapped"] = setting("Axes: `printed`, image (x, y) on (X, Y), or `mapped`, image x on Y.")
    rotation: Literal["printed", "repaired"] = setting(
        "Rotation: `printed`, the transposed matrix, or `repaired`, vehicle to world."
    )
    lambda_x: float = setting("Gain lambda_X of the force along X.", gt=0.0)
    lambda_y: float = setting("Gain lambda_Y of the force along Y.", gt=0.0)


def compose(target: Floats, obstacle_image: Floats, road: Floats, config: TotalFieldConfig) -> Force:
    """The forces at the vehicle in its axes, each (2,), as they act: what the paper subtracts is negative here.

    `obstacle_image` is F_rep in image axes (x right, y).
    """
    obstacle = -(obstacle_image if config.axes == "printed" else obstacle_image[::-1])
    edge = -np.array([config.lambda_x, config.lambda_y]) * road
    return Force(target, obstacle, edge, target + obstacle + edge)


def to_world(force: Floats, yaw_rad: float, config: TotalFieldConfig) -> Floats:
    """(2,) (F_X', F_Y') in the world.

    Printed is [[cos, sin], [-sin, cos]], which takes the world to the vehicle. Its transpose is meant:
    straight ahead must stay straight ahead at any yaw.
    """
    matrix = rotation(yaw_rad)
    world: Floats = (matrix.T if config.rotation == "printed" else matrix) @ force
    return world
