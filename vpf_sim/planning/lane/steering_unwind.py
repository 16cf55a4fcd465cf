"""Where a path across the road comes to rest, limited by the rate of the steering.

The steering turns at a rate of time, so its change j on a metre of way falls with the speed: a car that speeds up in a
swerve runs wide. The slope of a path with slope p >= 0 and bend b is largest where the wheels are straight, b / j of
way from here:

    p_1 = p + b^2 / (2 j).

From there the bend goes to -sqrt(p_1 j) and back to 0 on 2 sqrt(p_1 / j) of way; or, where that exceeds the tightest
curve k, on p_1 / k + k / j. The path moves p_1 / 2 aside on a metre of it.
"""

import numpy as np

from vpf_sim.types import Floats


def rest(slope: float, bend_per_m: float, steering_per_m2: Floats, tightest_per_m: Floats) -> tuple[Floats, Floats]:
    """(N,) m of way until the path can lead along the road again, and (N,) m across it until then, + is right.

    `steering_per_m2`, `tightest_per_m` (N,): j and k of each speed.
    """
    straightened = abs(bend_per_m) / steering_per_m2
    side = np.where(slope + 0.5 * bend_per_m * straightened < 0.0, -1.0, 1.0)
    largest = side * slope + 0.5 * abs(bend_per_m) * straightened
    sharpest = np.sqrt(largest * steering_per_m2)
    gentle, sharp = 2.0 * sharpest / steering_per_m2, largest / tightest_per_m + tightest_per_m / steering_per_m2
    way = np.where(sharpest > tightest_per_m, sharp, gentle)
    # The largest slope is still ahead of a path that turns aside, and lies behind one that turns back already.
    until = side * slope * straightened + abs(bend_per_m) * straightened**2 / 3.0
    since = largest * straightened - steering_per_m2 * straightened**3 / 6.0
    turns_on = side * bend_per_m > 0.0
    shift = side * (0.5 * largest * way + np.where(turns_on, until, -since))
    return way + np.where(turns_on, straightened, -straightened), shift
