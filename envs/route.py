"""The route through a scenario: the centre of the ego's lane, from the start to beyond the goal."""

import numpy as np

from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Floats

BEYOND_GOAL_M = 40.0
SPACING_M = 1.0


class Route:
    """A lane's centre as a path.

    Its length between two s is exact: the distance along the carriageway's centre less the lane's offset times the
    road's change of heading.
    """

    def __init__(self, centre: CentreLine, scenario: Scenario) -> None:
        self._centre = centre
        self._start_s_m = scenario.ego.s_m
        self.offset_m = scenario.road.lane_offset_m(scenario.ego.lane)
        self._start_heading_rad = centre.heading_at(self._start_s_m)
        self.length_m = self.progress(scenario.goal.s_m)
        self.goal_m = centre.position_at(scenario.goal.s_m, self.offset_m)

    def progress(self, s_m: float) -> float:
        """m along the lane from the start to s."""
        return s_m - self._start_s_m - self.offset_m * (self._centre.heading_at(s_m) - self._start_heading_rad)

    def waypoints(self) -> Floats:
        """(M, 2) m, 1 m apart, from the start to `BEYOND_GOAL_M` beyond the goal."""
        wanted = np.arange(0.0, self.length_m + BEYOND_GOAL_M, SPACING_M)
        s = self._start_s_m + wanted
        for _ in range(8):  # Newton's method: the lane is 1 - offset * curvature times as long as the centre line
            turn = self._centre.heading(s) - self._start_heading_rad
            excess = s - self._start_s_m - self.offset_m * turn - wanted
            s = s - excess / (1.0 - self.offset_m * self._centre.curvature(s))
        return self._centre.position(s, self.offset_m)
