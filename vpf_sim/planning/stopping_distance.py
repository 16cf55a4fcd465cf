"""The stopping distance, v t + v^2 / (2 b), and its inverse."""

from math import sqrt

import numpy as np

from vpf_sim.types import Floats


def stopping_way(speed_mps: Floats | float, brake_mps2: float, reaction_s: float = 0.0) -> Floats:
    """m until the car stands."""
    way: Floats = np.asarray(speed_mps**2 / (2.0 * brake_mps2) + speed_mps * reaction_s)
    return way


def stopping_speed(way_m: float, brake_mps2: float, reaction_s: float) -> float:
    """m/s from which the car stands after a way; 0 where there is none."""
    return brake_mps2 * (sqrt(reaction_s**2 + 2.0 * max(way_m, 0.0) / brake_mps2) - reaction_s)
