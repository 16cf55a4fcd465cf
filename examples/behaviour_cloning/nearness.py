"""What is how near in front of the car: a second task of the training, which makes small obstacles worth seeing.

Driving through all that is small costs little in the labels, since few decisions are about it. Whether something stands
at 15 m is asked of every picture.
"""

import numpy as np

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.scene.truth import TrueScene
from vpf_sim.types import Singles

SIDE_M, COLUMNS = 5.0, 10  # of the road to either side of the car's middle, and strips that it is divided into
FAR_M = 30.0  # from here on nothing is near
FRONT_M = 2.5  # of the car, before its middle
EDGES_M = np.linspace(-SIDE_M, SIDE_M, COLUMNS + 1)


class Nearness:
    """Reads it from the world of one episode."""

    def __init__(self, setup: DriverSetup) -> None:
        self._truth = TrueScene(setup)

    def at(self, observation: Observation) -> Singles:
        """(COLUMNS,) from left to right, for strips along the road: 0 is nothing within FAR_M, 1 is touching."""
        scene = self._truth.at(observation)
        tracks, ego = scene.tracks, scene.ego
        gap_m = tracks.s_m - ego.s_m - 0.5 * tracks.length_m - FRONT_M
        middle_m, half_m = tracks.d_m - ego.d_m, 0.5 * tracks.width_m
        near = np.clip(1.0 - gap_m / FAR_M, 0.0, 1.0) * (tracks.s_m > ego.s_m)
        inside = (middle_m - half_m < EDGES_M[1:, None]) & (middle_m + half_m > EDGES_M[:-1, None])
        found: Singles = np.max(np.where(inside, near, 0.0), axis=1, initial=0.0).astype(np.float32)
        return found
