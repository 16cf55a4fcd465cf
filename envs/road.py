"""highway-env roads from scenarios: exact lanes and the network of one carriageway."""

from typing import Any

import numpy as np
from highway_env.road.lane import AbstractLane, LineType
from highway_env.road.road import LaneIndex, RoadNetwork
from highway_env.road.road import Road as HighwayRoad

from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.parts import Road
from vpf_sim.types import Floats

START, END = "start", "end"  # the nodes of the network


def centre_line(road: Road) -> CentreLine:
    """The centre line of the carriageway, between the lanes of its two halves."""
    return CentreLine(road)


class OffsetLane(AbstractLane):  # type: ignore[misc]
    """A lane at a constant offset right of the carriageway's centre line, over the whole length of the road.

    Its longitudinal coordinate is s along the carriageway's centre line: objects side by side have the same s, and the
    dashes of all lane lines are aligned. In a bend a metre of s is 1 - offset * curvature metres of the lane. Both
    coordinates continue straight beyond both ends.
    """

    def __init__(self, centre: CentreLine, offset_m: float, width_m: float, line_types: tuple[int, int]) -> None:
        self.centre = centre
        self.offset_m = offset_m
        self.width_m = width_m
        self.line_types = list(line_types)  # left, right
        self.length = centre.length_m
        self.speed_limit = None
        self.forbidden = False
        self.priority = 0

    def position(self, longitudinal: float, lateral: float) -> Floats:
        return np.array(self.centre.position_at(longitudinal, self.offset_m + lateral))

    def local_coordinates(self, position: Floats) -> tuple[float, float]:
        s, lateral = self.centre.local_at(float(position[0]), float(position[1]))
        return s, lateral - self.offset_m

    def heading_at(self, longitudinal: float) -> float:
        return self.centre.heading_at(longitudinal)

    def width_at(self, longitudinal: float) -> float:  # noqa: ARG002 (highway-env's signature)
        return self.width_m

    def positions(self, longitudinal: Floats, lateral: Floats | float = 0.0) -> Floats:
        """(N, 2) m, `position` for N points."""
        return self.centre.position(longitudinal, self.offset_m + np.asarray(lateral))

    def headings(self, longitudinal: Floats) -> Floats:
        """(N,) rad, `heading_at` for N points."""
        return self.centre.heading(longitudinal)

    def to_config(self) -> dict[str, Any]:
        raise NotImplementedError("a scenario's road is written as a whole, not lane by lane")


class Carriageway(RoadNetwork):  # type: ignore[misc]
    """The lane network of one road; lane 0 is the leftmost, as in highway-env."""

    def __init__(self, road: Road) -> None:
        super().__init__()
        self.centre = centre_line(road)
        self.lane_width_m = road.lane_width_m
        self.half_width_m = road.half_width_m
        self.appearance = road.look
        lines = [LineType.STRIPED] * (road.lanes + 1)
        lines[0], lines[road.lanes] = _edge_line(road, "left"), _edge_line(road, "right")
        if road.oncoming_lanes:
            lines[road.oncoming_lanes] = LineType.CONTINUOUS_LINE
        for index in range(road.lanes):
            offset_m = road.lane_offset_m(road.lanes - index)
            lane = OffsetLane(self.centre, offset_m, road.lane_width_m, (lines[index], lines[index + 1]))
            lane.forbidden = index < road.oncoming_lanes  # to lane changes of highway-env's drivers
            self.add_lane(START, END, lane)

    def lane_at(self, lateral_m: float) -> LaneIndex:
        """The index of the lane at a lateral position; the outermost lane beyond the edges."""
        count = len(self.graph[START][END])
        index = int((lateral_m + self.half_width_m) // self.lane_width_m)
        return START, END, min(max(index, 0), count - 1)

    def get_closest_lane_index(self, position: Floats, heading: float | None = None) -> LaneIndex:  # noqa: ARG002
        """The lane at a position; the heading is ignored since all lanes have one direction."""
        return self.lane_at(self.centre.local_at(float(position[0]), float(position[1]))[1])


def _edge_line(road: Road, side: str) -> int:
    painted = road.look.edge_lines in ("both", side)
    return int(LineType.CONTINUOUS_LINE if painted else LineType.NONE)


def build_road(scenario: Scenario, np_random: np.random.Generator) -> HighwayRoad:
    """The empty highway-env road of a scenario; the environment adds the objects and the ego car."""
    return HighwayRoad(network=Carriageway(scenario.road), np_random=np_random)
