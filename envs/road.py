"""highway-env roads from scenarios: exact lanes and the network of one carriageway."""

from collections.abc import Iterable, Sequence
from typing import NoReturn

import numpy as np
from highway_env.road.lane import AbstractLane, LineType
from highway_env.road.road import LaneIndex, RoadNetwork

from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.envs.contacts import ContactRoad, corners
from vpf_sim.envs.network import LaneUse, OnRoad, Place, Point, RoadLines
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.lane_places import LanePlaces
from vpf_sim.scenarios.parts import Road
from vpf_sim.types import Floats

START, END = "start", "end"  # the nodes of the network
OFF_ROAD_MARGIN_M = 0.2
BEYOND_M, EVERY_M = 60.0, 2.0  # of the lines from above: beyond the road's ends, and between points


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

    def to_config(self) -> NoReturn:
        raise NotImplementedError("a scenario's road is written as a whole, not lane by lane")


class VaryingLane(OffsetLane):
    """A lane whose offset and width are functions of s; its lateral coordinate is from its own middle."""

    def __init__(self, centre: CentreLine, places: LanePlaces, lane: int, line_types: tuple[int, int]) -> None:
        """`lane` is counted from the right, from 1."""
        self._places, self._lane = places, lane
        self.knots_m = places.s_m  # where the width's slope changes
        super().__init__(centre, self._middle(0.0), self.width_at(0.0), line_types)

    def _middle(self, s_m: float) -> float:
        return float(self._places.middle(self._lane, s_m))

    def position(self, longitudinal: float, lateral: float) -> Floats:
        return np.array(self.centre.position_at(longitudinal, self._middle(longitudinal) + lateral))

    def local_coordinates(self, position: Floats) -> tuple[float, float]:
        s, lateral = self.centre.local_at(float(position[0]), float(position[1]))
        return s, lateral - self._middle(s)

    def width_at(self, longitudinal: float) -> float:
        borders = self._places.borders(longitudinal)
        return float(borders[-self._lane] - borders[-self._lane - 1])

    def positions(self, longitudinal: Floats, lateral: Floats | float = 0.0) -> Floats:
        return self.centre.position(longitudinal, self._places.middle(self._lane, longitudinal) + np.asarray(lateral))


class Carriageway(RoadNetwork):  # type: ignore[misc]
    """The lane network of one road; lane 0 is the leftmost, as in highway-env."""

    def __init__(self, road: Road) -> None:
        super().__init__()
        self.centre = centre_line(road)
        self.lane_width_m = road.lane_width_m
        self.half_width_m = road.half_width_m  # the largest
        self.places = road.lane_places
        self.road, self.appearance = road, road.look
        lines = [LineType.STRIPED] * (road.lanes + 1)
        lines[0], lines[road.lanes] = _edge_line(road, "left"), _edge_line(road, "right")
        if road.oncoming_lanes:
            lines[road.oncoming_lanes] = LineType.CONTINUOUS_LINE
        for index in range(road.lanes):
            lane = self._lane(road, road.lanes - index, (lines[index], lines[index + 1]))
            lane.oncoming = index < road.oncoming_lanes
            lane.forbidden = lane.oncoming  # to lane changes of highway-env's drivers
            self.add_lane(START, END, lane)

    def _lane(self, road: Road, number: int, lines: tuple[int, int]) -> OffsetLane:
        """A lane, counted from the right."""
        if self.places is not None:
            return VaryingLane(self.centre, self.places, number, lines)
        return OffsetLane(self.centre, road.lane_offset_m(number), road.lane_width_m, lines)

    def lane_at(self, place: Place) -> LaneIndex:
        """The index of the lane at a place; the outermost lane beyond the edges."""
        count = len(self.graph[START][END])
        s, lateral = place
        if self.places is None:
            index = int((lateral + self.half_width_m) // self.lane_width_m)
        else:
            index = int(np.searchsorted(self.places.borders(s), lateral, side="right")) - 1
        return START, END, min(max(index, 0), count - 1)

    def _edges(self, s_m: float) -> tuple[float, float]:
        """(left, right) m of the carriageway at s, right of the centre line."""
        if self.places is None:
            return -self.half_width_m, self.half_width_m
        borders = self.places.borders(s_m)
        return float(borders[0]), float(borders[-1])

    def get_closest_lane_index(self, position: Floats, heading: float | None = None) -> LaneIndex:  # noqa: ARG002
        """The lane at a position; the heading is ignored since all lanes have one direction."""
        return self.lane_at(self.centre.local_at(float(position[0]), float(position[1])))

    def place_at(self, x_m: float, y_m: float, near_s_m: float | None = None) -> Place:  # noqa: ARG002
        """(s, lateral) of a world point."""
        return self.centre.local_at(x_m, y_m)

    def lane_of(self, ego: OnRoad) -> LaneIndex:
        """The lane at the ego's place."""
        return self.lane_at(ego.place)

    def is_off_road(self, ego: OnRoad) -> bool:
        """Whether a corner of the ego is beyond the carriageway's edges or ends by more than the margin."""
        s, lateral = ego.place
        reach_m = ego.diagonal / 2.0
        length_m, half_width_m = self.centre.length_m, self.half_width_m
        if self.places is None and abs(lateral) + reach_m < half_width_m and reach_m < s < length_m - reach_m:
            return False
        return any(
            self._beyond_m(place) > OFF_ROAD_MARGIN_M
            or not -OFF_ROAD_MARGIN_M <= place[0] <= length_m + OFF_ROAD_MARGIN_M
            for place in (self.centre.local_at(*corner) for corner in corners(ego))
        )

    def _beyond_m(self, place: Place) -> float:
        """m, how far a place is beyond the nearer edge; < 0 on the carriageway."""
        left, right = self._edges(place[0])
        return max(place[1] - right, left - place[1])

    def lane_use(self, corners: Sequence[Point], near_s_m: float) -> LaneUse:  # noqa: ARG002
        """How the corners of a car lie on the lanes; the road's ends do not count."""
        places = [self.centre.local_at(x, y) for x, y in corners]
        is_outside = any(self._beyond_m(place) > 0.0 for place in places)
        return LaneUse(is_outside, not is_outside and len({self.lane_at(place) for place in places}) == 1)

    def edges_at(self, x_m: float, y_m: float, heading_rad: float) -> tuple[float, float]:  # noqa: ARG002
        """(left, right) m, offsets from a point to the edges of the carriageway, left < 0."""
        s, lateral = self.centre.local_at(x_m, y_m)
        left, right = self._edges(s)
        return left - lateral, right - lateral

    def lines(self) -> RoadLines:
        """The road from above: the carriageway, its edges, and the lines between its lanes."""
        along = np.arange(-BEYOND_M, self.centre.length_m + BEYOND_M, EVERY_M)
        left, *between, right = [self.centre.position(along, border) for border in self._borders(along)]
        return RoadLines(((left, right),), (left, right), tuple(between))

    def _borders(self, s_m: Floats) -> Iterable[float | Floats]:
        """The borders of the lanes from the left, m right of the centre line, at each s."""
        if self.places is not None:
            return self.places.borders(s_m)
        count = len(self.graph[START][END])
        return [-self.half_width_m + self.lane_width_m * line for line in range(count + 1)]


def _edge_line(road: Road, side: str) -> int:
    painted = road.look.edge_lines in ("both", side)
    return int(LineType.CONTINUOUS_LINE if painted else LineType.NONE)


def build_road(scenario: Scenario, np_random: np.random.Generator) -> ContactRoad:
    """The empty highway-env road of a scenario; the environment adds the objects and the ego car."""
    return ContactRoad(network=Carriageway(scenario.road), np_random=np_random)
