"""Which lanes of a highway-env network a route uses, from the ego's start to its destination and beyond.

A road is a pair of nodes (from, to) with parallel lanes. Lanes are named as in highway-env: (from, to, number).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi

from highway_env.road.lane import AbstractLane
from highway_env.road.road import LaneIndex, RoadNetwork

from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats

Road = tuple[str, str]
LEADS_ON_M = 3.0  # a lane leads into another if its end is nearer to it
SHARPEST_RAD = pi / 3.0  # change of heading from a road to one that continues it
SHORTEST_M = 1.0  # a lane of which less would be used is left out


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of a road: it begins in one lane and ends in the same or in another."""

    entered: LaneIndex
    left: LaneIndex
    start_m: float  # along the entered lane
    end_m: float

    @property
    def changes_lane(self) -> bool:
        return bool(self.entered != self.left)


def roads_to(network: RoadNetwork, start: LaneIndex, destination: str) -> list[Road]:
    """The start's road and those that lead from it to a node; the start's alone if none do."""
    nodes = network.shortest_path(start[1], destination)
    return [start[:2], *pairwise(nodes)]


def stretches(
    network: RoadNetwork, start: LaneIndex, place: Floats, roads: Sequence[Road], length_m: float
) -> list[Stretch]:
    """The stretches from a place on the start lane over `roads` and on along the lanes, for at least a length.

    They are shorter in all where no road goes on. The last one ends where the length is reached.
    """
    found: list[Stretch] = []
    for index, allowed in zip(range(len(roads)), _lanes_that_lead_on(network, roads), strict=True):
        entered = start if index == 0 else _nearest_lane(network, roads[index], place)
        number = min(allowed, key=lambda other: (abs(other - entered[2]), other))
        place = _append(network, found, entered, (*roads[index], number), place)
    while _excess_m(found, length_m) < 0.0:
        last = network.get_lane(found[-1].left)
        entered_next = _continuation(network, found[-1].left[1], place, last.heading_at(last.length))
        if entered_next is None:
            break
        place = _append(network, found, entered_next, entered_next, place)
    if not found[-1].changes_lane:
        spare_m = max(0.0, _excess_m(found, length_m))
        found[-1] = replace(found[-1], end_m=max(found[-1].start_m + SHORTEST_M, found[-1].end_m - spare_m))
    return found


def _excess_m(found: Sequence[Stretch], length_m: float) -> float:
    """m, by how much the stretches are longer than a length."""
    return sum(one.end_m - one.start_m for one in found) - length_m


def _append(network: RoadNetwork, found: list[Stretch], entered: LaneIndex, left: LaneIndex, place: Floats) -> Floats:
    """Add the stretch from a place to the end of a road; returns that end."""
    lane: AbstractLane = network.get_lane(entered)
    start_m = max(0.0, float(lane.local_coordinates(place)[0]))
    end_m = float(lane.length)
    if end_m - start_m >= SHORTEST_M or not found:
        found.append(Stretch(entered, left, start_m, end_m))
    other = network.get_lane(left)
    end: Floats = other.position(other.length, 0.0)
    return end


def _lanes_that_lead_on(network: RoadNetwork, roads: Sequence[Road]) -> list[list[int]]:
    """For each road the numbers of the lanes that lead into the next one, by its lanes that lead on."""
    allowed = [list(range(len(network.graph[roads[-1][0]][roads[-1][1]])))]
    for road, onward in zip(reversed(roads[:-1]), reversed(roads[1:]), strict=True):
        lanes = network.graph[road[0]][road[1]]
        targets = [network.get_lane((*onward, number)) for number in allowed[0]]
        gaps_m = [min(float(target.distance(lane.position(lane.length, 0.0))) for target in targets) for lane in lanes]
        reach_m = max(LEADS_ON_M, min(gaps_m) + 0.1)
        allowed.insert(0, [number for number, gap_m in enumerate(gaps_m) if gap_m <= reach_m])
    return allowed


def _nearest_lane(network: RoadNetwork, road: Road, place: Floats) -> LaneIndex:
    lanes = network.graph[road[0]][road[1]]
    number = min(range(len(lanes)), key=lambda index: float(lanes[index].distance(place)))
    return (*road, number)


def _continuation(network: RoadNetwork, node: str, place: Floats, heading: float) -> LaneIndex | None:
    """The lane that goes on from a node most straight; None at the end of the roads."""
    best = min(_onward(network, node, place, heading), default=None)
    return None if best is None else best[1]


def _onward(network: RoadNetwork, node: str, place: Floats, heading: float) -> Iterator[tuple[float, LaneIndex]]:
    """Lanes from a node, each with its gap in position and heading."""
    for end, lanes in network.graph.get(node, {}).items():
        for number, lane in enumerate(lanes):
            turn = abs(wrap_angle(lane.heading_at(max(0.0, lane.local_coordinates(place)[0])) - heading))
            gap_m = float(lane.distance(place))
            if turn <= SHARPEST_RAD and gap_m <= LEADS_ON_M:
                yield gap_m + turn, (node, end, number)
