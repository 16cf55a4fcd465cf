"""The stopping distance, v t + v^2 / (2 b).

Each use has a deceleration b by how certain the obstacle is: the lowest before a blocked road, more before an obstacle
that is too near to be passed on the chosen side, the most before what is not seen yet.
"""

import numpy as np

from vpf_sim.types import Floats


def stopping_way(speed_mps: Floats | float, brake_mps2: float, reaction_s: float = 0.0) -> Floats:
    """m until the car stands."""
    way: Floats = np.asarray(speed_mps**2 / (2.0 * brake_mps2) + speed_mps * reaction_s)
    return way
