"""The lanes in which highway-env's cars are going to drive, as their routes say."""

from typing import Any

import numpy as np
from highway_env.road.lane import AbstractLane, StraightLane
from highway_env.road.road import LaneIndex, RoadNetwork

from vpf_sim.geometry import unwrapped
from vpf_sim.scene.lanes import LaneLine, LanePlace
from vpf_sim.types import Floats

STEP_M = 2.0  # between the points
AHEAD_M = 150.0  # beyond the end of the lane that a car is in


class PlannedLanes:
    """Keeps the lines of one road network."""

    def __init__(self, network: RoadNetwork) -> None:
        self._network = network
        self._lines: dict[tuple[LaneIndex, ...], LaneLine] = {}

    def place_of(self, car: Any) -> LanePlace | None:
        """A car's place in the lane that it steers to; None of what does not drive by highway-env's lanes."""
        target = getattr(car, "target_lane_index", None)
        if target is None:
            return None
        along, right = self._network.get_lane(target).local_coordinates(car.position)
        key = (target, *(car.route or ()))
        if key not in self._lines:
            self._lines[key] = self._line(target, list(car.route or ()))
        return LanePlace(self._lines[key], float(along), float(right))

    def _line(self, index: LaneIndex, route: list[LaneIndex]) -> LaneLine:
        """The line from the beginning of a lane along a route, and on without one, as highway-env's cars choose."""
        lane = self._network.get_lane(index)
        parts, ahead_m = [_points(lane, 0.0)], 0.0
        while ahead_m < AHEAD_M:
            end = lane.position(lane.length, 0.0)
            following = self._network.next_lane(index, route=route, position=end)
            if following == index:
                break
            index, lane = following, self._network.get_lane(following)
            start_m = max(0.0, float(lane.local_coordinates(end)[0]))
            ahead_m += max(lane.length - start_m, STEP_M)
            parts.append(_points(lane, start_m + STEP_M))
        x, y, heading = np.concatenate(parts).T
        along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        return LaneLine(along, x, y, unwrapped(heading))


def _points(lane: AbstractLane, from_m: float) -> Floats:
    """(N, 3) x m, y m, heading rad along the middle of a lane; none where it is shorter than `from_m`."""
    count = 2 if type(lane) is StraightLane else int(max(lane.length - from_m, 0.0) / STEP_M) + 2
    places = np.linspace(from_m, lane.length, count) if lane.length > from_m else ()
    return np.array([(*lane.position(s, 0.0), lane.heading_at(s)) for s in places], float).reshape(-1, 3)
