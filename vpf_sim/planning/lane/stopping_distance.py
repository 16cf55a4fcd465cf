"""The way of a stop, v t + v^2 / (2 b).

Each use names its deceleration b, by how sure what it stops for is: 2 m/s^2 before a blocked road (`brake_mps2` of the
reference), 3 before a body that is too near to be passed on the chosen side, 3.5 where more than comfort would be
needed (`pace`), 4 before what is not seen yet (`sight`), which leaves the car's own 6 for what is seen later still. The
controller's a_0 is 3.6, inside nuPlan's 4.05.
"""

import numpy as np

from vpf_sim.types import Floats


def stopping_way(speed_mps: Floats | float, brake_mps2: float, reaction_s: float = 0.0) -> Floats:
    """m until the car stands."""
    way: Floats = np.asarray(speed_mps**2 / (2.0 * brake_mps2) + speed_mps * reaction_s)
    return way
