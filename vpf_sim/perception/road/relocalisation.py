"""Another road than the one that is followed, which explains more of a frame's ridges.

Whoever is led away along a mirror image is soon as sure as he is wrong, and looks for lines about wrong places only. So
a followed road is compared, from time to time, with the best one found from scratch.
"""

import numpy as np

from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.markings import RidgeMap, comb, explained
from vpf_sim.perception.road.model import PITCH, WIDTH, seen_places, state_of
from vpf_sim.types import Floats

HEADINGS_RAD = np.radians(np.arange(-3.0, 3.01, 0.6))  # about that of the followed road: the own motion tells it well
MORE_LINES = 0.15  # by which a rival must explain more


def rival_of(state: Floats, ridges: RidgeMap, view: BirdsEye, numbers: Floats, least_comb: float) -> Floats | None:
    """(8,) the state of the road, as wide as the followed one's and about in its direction, that explains more.

    `numbers` (L,) are of the lines of both; None where no road reaches the score `least_comb`, or none explains more.
    """
    place, heading, width = (float(state[i]) for i in (0, 1, WIDTH))
    score, (y, direction, curvature, _) = comb(ridges, view, np.array([width]), width, heading, heading + HEADINGS_RAD)
    if score < least_comb:
        return None
    rival = state_of(y + width * round((place - y) / width), direction, curvature, width)
    rival[PITCH] = state[PITCH]
    return rival if outdoes(rival, state, ridges, view, numbers) else None


def outdoes(rival: Floats, state: Floats, ridges: RidgeMap, view: BirdsEye, numbers: Floats) -> bool:
    """Whether the lines of one road explain clearly more of the ridges than those of another."""
    more, less = (
        explained(ridges, view, *seen_places(of, numbers, view.forward_m, view.camera)) for of in (rival, state)
    )
    return more > less + MORE_LINES
