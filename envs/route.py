"""The route: the centre of a lane, from the start to beyond the goal."""

from math import inf
from typing import NamedTuple

import numpy as np

from vpf_sim.envs.centre_line import ReferenceLine
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Floats, Turn

BEYOND_GOAL_M = 40.0
SPACING_M = 1.0


class Fork(NamedTuple):
    """A part of the route along which `Observation.turn` names the way to take."""

    start_m: float  # along the route
    end_m: float
    turn: Turn


class Route:
    """A lane's centre as a path: `offset_m` right of a reference line, from its `start_s_m` to its `goal_s_m`.

    Its length between two s is exact: the distance along the reference line less the offset times the line's change of
    heading. `goal_sides_m` are the ends of the goal's cross-section, right of the route.
    """

    def __init__(
        self,
        centre: ReferenceLine,
        start_s_m: float,
        goal_s_m: float,
        offset_m: float = 0.0,
        goal_sides_m: tuple[float, float] = (-inf, inf),
        forks: tuple[Fork, ...] = (),
    ) -> None:
        self.centre = centre
        self.offset_m = offset_m
        self.start_s_m, self.goal_s_m = start_s_m, goal_s_m
        self._goal_sides_m, self._forks = goal_sides_m, forks
        self._start_heading_rad = centre.heading_at(start_s_m)
        self.length_m = self.progress(goal_s_m)
        self.goal_m = centre.position_at(goal_s_m, offset_m)

    @classmethod
    def of(cls, centre: ReferenceLine, scenario: Scenario) -> "Route":
        """The route through a scenario: the centre of the ego's lane."""
        return cls(centre, scenario.ego.s_m, scenario.goal.s_m, scenario.road.lane_offset_m(scenario.ego.lane))

    def progress(self, s_m: float) -> float:
        """m along the lane from the start to s."""
        return s_m - self.start_s_m - self.offset_m * (self.centre.heading_at(s_m) - self._start_heading_rad)

    def is_at_goal(self, place: tuple[float, float]) -> bool:
        """Whether a place, (s, lateral) on the reference line, is beyond the goal's cross-section."""
        left_m, right_m = self._goal_sides_m
        return place[0] >= self.goal_s_m and left_m <= place[1] - self.offset_m <= right_m

    def turn(self, route_m: float) -> Turn:
        """The way to take next, at a distance along the route."""
        return next((each.turn for each in self._forks if each.start_m <= route_m < each.end_m), "lane")

    def waypoints(self) -> Floats:
        """(M, 2) m, 1 m apart, from the start to `BEYOND_GOAL_M` beyond the goal."""
        wanted = np.arange(0.0, self.length_m + BEYOND_GOAL_M, SPACING_M)
        s = self.start_s_m + wanted
        for _ in range(8):  # Newton's method: the lane is 1 - offset * curvature times as long as the line
            turn = self.centre.heading(s) - self._start_heading_rad
            excess = s - self.start_s_m - self.offset_m * turn - wanted
            s = s - excess / (1.0 - self.offset_m * self.centre.curvature(s))
        return self.centre.position(s, self.offset_m)
