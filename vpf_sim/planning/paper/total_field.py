"""The sum of the fields and its direction in the world (paper, section V).

    F_XT = F_att_x - F_rep_x - lambda_X F_X,    F_YT = F_att_y - F_rep_y - lambda_Y F_Y

F_X, F_Y there are the road's F_rep_rd. Image x (right) is summed with the vehicle's X (forward) in print; it belongs on
Y, and what the image says of time belongs on X.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vpf_sim.geometry import rotation
from vpf_sim.types import Floats, Force


@dataclass(frozen=True, slots=True)
class TotalFieldConfig:
    """`printed` axes: image (x, y) on (X, Y); `mapped`: image x on Y. `printed` rotation: the transposed matrix."""

    axes: Literal["printed", "mapped"]
    rotation: Literal["printed", "repaired"]
    lambda_x: float
    lambda_y: float

    def __post_init__(self) -> None:
        if not (self.lambda_x > 0.0 and self.lambda_y > 0.0):
            raise ValueError(f"lambda_x, lambda_y: expected > 0, got {self.lambda_x}, {self.lambda_y}")


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
