"""Sizes of objects by class, known before they are observed."""

import numpy as np

from vpf_sim.types import Floats

LENGTH_M = 1.0  # of a narrow object
CAR_WIDTH_M, CAR_LENGTH_M = 1.0, 5.5  # from which an object may be a car; its length
TRUCK_WIDTH_M, TRUCK_LENGTH_M = 2.25, 9.0  # or a truck


def lengths_m(width_m: Floats) -> Floats:
    """(K,) largest lengths of objects of these widths (K,): of most only the face is observed."""
    return np.select([width_m > TRUCK_WIDTH_M, width_m > CAR_WIDTH_M], [TRUCK_LENGTH_M, CAR_LENGTH_M], LENGTH_M)
