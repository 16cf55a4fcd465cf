"""The way that a driver gets where roads part: left, straight or right, as CARLA's leaderboard does.

Of the roads that leave a node, "straight" is the one whose direction changes least, and the others are to its left or
right. So on a roundabout "straight" goes on around it, and "right" leaves it.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import atan2

from highway_env.road.lane import AbstractLane
from highway_env.road.road import LaneIndex, RoadNetwork

from vpf_sim.envs.highway.lanes import Stretch
from vpf_sim.envs.route import Fork
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Turn

BEARING_M = 20.0  # how far along a road its direction is measured
NOTICE_S, NOTICE_M = 4.0, 20.0  # before the fork, at least so long and so far
JUNCTION_M = 30.0  # and up to this far behind it


def forks(
    network: RoadNetwork, route: Sequence[Stretch], ends_m: Sequence[float], speed_mps: float
) -> tuple[Fork, ...]:
    """The forks on a route, with the way to take; `ends_m` are s, m, at the ends of its stretches.

    A lane change that leads to a fork belongs to it.
    """
    found = []
    for number, (before, after) in enumerate(pairwise(route)):
        turn = turn_at(network, before.left, after.entered)
        if turn == "lane":
            continue
        fork_m, first = ends_m[number], number
        while first >= 0 and route[first].changes_lane:
            first -= 1
        changed_from_m = (ends_m[first] if first >= 0 else 0.0) if first < number else fork_m
        start_m = min(changed_from_m, fork_m - max(NOTICE_M, NOTICE_S * speed_mps))
        found.append(Fork(start_m, fork_m + min(after.end_m - after.start_m, JUNCTION_M), turn))
    return tuple(found)


def turn_at(network: RoadNetwork, before: LaneIndex, after: LaneIndex) -> Turn:
    """The way from one lane into another; "lane" where only one road goes on."""
    lane = network.get_lane(before)
    roads = network.graph.get(before[1], {})
    if len(roads) < 2:
        return "lane"
    bearings = {end: _bearing_rad(lane, lanes) for end, lanes in roads.items()}
    bearings[after[1]] = _bearing_rad(lane, [network.get_lane(after)])
    straight = min(bearings, key=lambda end: abs(bearings[end]))
    if after[1] == straight:
        return "straight"
    return "left" if bearings[after[1]] < bearings[straight] else "right"


def _bearing_rad(lane: AbstractLane, onward: Sequence[AbstractLane]) -> float:
    """The direction of the nearest of some lanes, off the direction of the lane that ends there; + is right."""
    end, heading = lane.position(lane.length, 0.0), lane.heading_at(lane.length)
    other = min(onward, key=lambda candidate: float(candidate.distance(end)))
    start_m = max(0.0, other.local_coordinates(end)[0])
    x, y = (other.position(min(start_m + BEARING_M, other.length), 0.0) - other.position(start_m, 0.0)).tolist()
    return wrap_angle(atan2(y, x) - heading)
