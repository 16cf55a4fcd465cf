"""Another road than the tracked one, which explains more of a frame's ridges.

A filter that follows a reflection becomes certain of it and searches only there. So the tracked road is compared with
the best one found from scratch.
"""

import numpy as np

from vpf_sim.perception.road.config import RelocalisationConfig, RoadEdgeConfig, headings_rad
from vpf_sim.perception.road.markings import RidgeMap, comb, explained
from vpf_sim.perception.road.model import PITCH, WIDTH, seen_places, state_of
from vpf_sim.types import Floats


class Relocalisation:
    """Finds a road that explains more lines than the tracked one in consecutive searches."""

    def __init__(self, config: RelocalisationConfig, road: RoadEdgeConfig) -> None:
        self._config = config
        self._road = road
        self._outdone = 0  # consecutive searches that found such a road

    def search(self, state: Floats, agreement: float, ridges: RidgeMap, numbers: Floats) -> Floats | None:
        """(8,) the state of the other road once it lasts; `agreement` is the tracked road's share of visible lines."""
        config = self._config
        sure = agreement > config.sure_agreement or abs(state[1]) > config.straight_rad
        rival = None if sure else self.rival_of(state, ridges, numbers)
        self._outdone = 0 if rival is None else self._outdone + 1
        if self._outdone < config.searches:
            return None
        self._outdone = 0
        return rival

    def rival_of(self, state: Floats, ridges: RidgeMap, numbers: Floats) -> Floats | None:
        """(8,) the state of a road of the same width and nearly the same heading that explains more, or None.

        `numbers` (L,) are those of the lines of both roads.
        """
        place, heading, width = (float(state[i]) for i in (0, 1, WIDTH))
        around = heading + headings_rad(self._config.heading_limit_deg, self._road.comb.heading_step_deg)
        widths = np.array([width])
        score, (y, direction, curvature, _) = comb(ridges, widths, width, self._road.comb, heading, around)
        if score < self._road.least_comb:
            return None
        rival = state_of(y + width * round((place - y) / width), direction, curvature, width)
        rival[PITCH] = state[PITCH]
        return rival if self.outdoes(rival, state, ridges, numbers) else None

    def outdoes(self, rival: Floats, state: Floats, ridges: RidgeMap, numbers: Floats) -> bool:
        """Whether the lines of one road explain clearly more of the ridges than those of another."""
        reach_m, view = self._road.comb.reach_m, ridges.view
        more, less = (
            explained(ridges, *seen_places(of, numbers, view.forward_m, view.camera), reach_m) for of in (rival, state)
        )
        return more > less + self._config.more_lines
