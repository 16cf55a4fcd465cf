"""The route: the centre of a lane, from the start to beyond the goal."""

from math import inf
from typing import NamedTuple

import numpy as np

from vpf_sim.driver_interface import Turn
from vpf_sim.envs.centre_line import ReferenceLine
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.lane_places import LanePlaces
from vpf_sim.types import Floats

BEYOND_GOAL_M = 40.0
SPACING_M = 1.0
FINE_M = 0.1  # between the points that give a varying lane's length


class Fork(NamedTuple):
    """A part of the route along which `Observation.turn` names the road to take."""

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
        if (places := scenario.road.lane_places) is not None:
            return VaryingRoute(centre, scenario.ego.s_m, scenario.goal.s_m, places, scenario.ego.lane)
        return cls(centre, scenario.ego.s_m, scenario.goal.s_m, scenario.road.lane_offset_m(scenario.ego.lane))

    def offset_at(self, s_m: float) -> float:  # noqa: ARG002
        """m, the route right of the reference line at s."""
        return self.offset_m

    def progress(self, s_m: float) -> float:
        """m along the lane from the start to s."""
        return s_m - self.start_s_m - self.offset_m * (self.centre.heading_at(s_m) - self._start_heading_rad)

    def is_at_goal(self, place: tuple[float, float]) -> bool:
        """Whether a place, (s, lateral) on the reference line, is beyond the goal's cross-section."""
        left_m, right_m = self._goal_sides_m
        return place[0] >= self.goal_s_m and left_m <= place[1] - self.offset_at(place[0]) <= right_m

    def turn(self, route_m: float) -> Turn:
        """The road to take next, at a distance along the route."""
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


class VaryingRoute(Route):
    """The centre of a lane whose offset changes along the reference line; its length is that of a fine polyline."""

    def __init__(self, centre: ReferenceLine, start_s_m: float, goal_s_m: float, places: LanePlaces, lane: int) -> None:
        """`lane` is counted from the right, from 1."""
        self._places, self._lane = places, lane
        last_m = max(goal_s_m, places.s_m[-1]) + 2.0 * BEYOND_GOAL_M
        self._s_m = np.linspace(0.0, last_m, max(2, round(last_m / FINE_M)))
        points = centre.position(self._s_m, places.middle(lane, self._s_m))
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        self._along_m = along - np.interp(start_s_m, self._s_m, along)
        super().__init__(centre, start_s_m, goal_s_m, float(places.middle(lane, start_s_m)))
        self.goal_m = centre.position_at(goal_s_m, self.offset_at(goal_s_m))

    def offset_at(self, s_m: float) -> float:
        return float(self._places.middle(self._lane, s_m))

    def progress(self, s_m: float) -> float:
        beyond_m = min(s_m - self._s_m[0], 0.0) + max(s_m - self._s_m[-1], 0.0)
        return float(np.interp(s_m, self._s_m, self._along_m) + beyond_m)

    def waypoints(self) -> Floats:
        wanted = np.arange(0.0, self.length_m + BEYOND_GOAL_M, SPACING_M)
        s = np.interp(wanted, self._along_m, self._s_m)
        return self.centre.position(s, self._places.middle(self._lane, s))
