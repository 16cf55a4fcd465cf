"""The smooth centre line of a route over the stretches of a lane network.

Along a stretch it is the lane's centre. A lane change is spread over the whole stretch, by a quintic without slope and
curvature at both ends. Where the lanes of two roads do not meet exactly, a cubic bridges the joint.

The direction that a driver gets at a fork: left, straight or right, as CARLA's leaderboard does.

Of the roads that leave a node, "straight" is the one whose direction changes least, and the others are to its left or
right. So on a roundabout "straight" goes on around it, and "right" leaves it.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import atan2, hypot

import numpy as np
from highway_env.road.lane import AbstractLane
from highway_env.road.road import LaneIndex, RoadNetwork

from vpf_sim.driver_interface import Turn
from vpf_sim.envs.highway.lanes import SplineLine, Stretch
from vpf_sim.envs.route import Fork
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats

STEP_M = 0.25  # between the points along a lane
KNOT_M = 1.0  # between the points of the spline
GAP_M, KINK_RAD = 0.05, np.radians(1.0)  # a larger one is bridged
BRIDGE_M = 7.0  # taken off both roads for it
WIDE_GAP = 2.0  # or this many times the gap
BEARING_M = 20.0  # how far along a road its direction is measured
NOTICE_S, NOTICE_M = 4.0, 20.0  # before the fork, at least so long and so far
JUNCTION_M = 30.0  # and up to this far behind it


def centre_line(network: RoadNetwork, route: Sequence[Stretch]) -> tuple[SplineLine, list[float]]:
    """The line over the stretches, and s, m, at the end of each of them."""
    points, ends = _points(network, route[0]), []
    for stretch in route[1:]:
        onward = _points(network, stretch)
        ends.append(0.5 * (points[-1] + onward[0]))
        points = _joined(points, onward)
    line = SplineLine(_resampled(points))
    reached, found = 0.0, []
    for x, y in [end.tolist() for end in ends]:
        reached = line.local_at(x, y, _first_near(line, x, y, reached))[0]
        found.append(reached)
    return line, [*found, line.length_m]


def _points(network: RoadNetwork, stretch: Stretch) -> Floats:
    """(M, 2) m along a stretch."""
    lane: AbstractLane = network.get_lane(stretch.entered)
    count = max(2, round((stretch.end_m - stretch.start_m) / STEP_M) + 1)
    share = np.linspace(0.0, 1.0, count)
    along = stretch.start_m + share * (stretch.end_m - stretch.start_m)
    lateral = np.zeros(count)
    if stretch.changes_lane:
        other = network.get_lane(stretch.left)
        lateral = lane.local_coordinates(other.position(other.length, 0.0))[1] * _quintic(share)
    return np.array([lane.position(s, right) for s, right in zip(along.tolist(), lateral.tolist(), strict=True)])


def _quintic(share: Floats) -> Floats:
    """0 to 1 over [0, 1], without slope and curvature at both ends."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def _joined(before: Floats, after: Floats) -> Floats:
    """Two polylines as one, with a bridge over a gap or a kink."""
    gap_m = float(np.hypot(*(after[0] - before[-1])))
    kink = wrap_angle(_heading(after[:2]) - _heading(before[-2:]))
    if gap_m <= GAP_M and abs(kink) <= KINK_RAD:
        return np.concatenate([before, after[1:]])
    cut = round(max(BRIDGE_M, WIDE_GAP * gap_m) / STEP_M)
    before, after = before[: max(2, len(before) - cut)], after[min(cut, len(after) - 2) :]
    return np.concatenate([before, _bridge(before, after), after])


def _bridge(before: Floats, after: Floats) -> Floats:
    """(M, 2) m between two polylines: a cubic with their end points and directions (Hermite)."""
    start, end = before[-1], after[0]
    reach_m = float(np.hypot(*(end - start)))
    t = np.arange(STEP_M, reach_m - 0.5 * STEP_M, STEP_M)[:, None] / reach_m
    leaving, arriving = (reach_m * _direction(part) for part in (before[-2:], after[:2]))
    hermite: Floats = (
        (2.0 * t**3 - 3.0 * t**2 + 1.0) * start
        + (t**3 - 2.0 * t**2 + t) * leaving
        + (3.0 * t**2 - 2.0 * t**3) * end
        + (t**3 - t**2) * arriving
    )
    return hermite


def _resampled(points: Floats) -> Floats:
    """The polyline with points `KNOT_M` apart."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    wanted = np.linspace(0.0, along[-1], max(4, round(along[-1] / KNOT_M) + 1))
    return np.stack([np.interp(wanted, along, points[:, axis]) for axis in (0, 1)], axis=1)


def _first_near(line: SplineLine, x_m: float, y_m: float, from_m: float) -> float:
    """The first s after `from_m` at which the line comes nearest to a point on it."""
    s = np.arange(from_m, line.length_m, KNOT_M)
    away_m = np.hypot(*(line.position(s) - (x_m, y_m)).T)
    close = np.flatnonzero(away_m < away_m.min() + 2.0 * KNOT_M)
    here = close[close < close[0] + 10]  # of a line that comes by again, the first time
    return float(s[here[int(np.argmin(away_m[here]))]])


def _heading(pair: Floats) -> float:
    return float(np.arctan2(*(pair[1] - pair[0])[::-1]))


def _direction(pair: Floats) -> Floats:
    dx, dy = (pair[1] - pair[0]).tolist()
    return np.array([dx, dy]) / hypot(dx, dy)


def forks(
    network: RoadNetwork, route: Sequence[Stretch], ends_m: Sequence[float], speed_mps: float
) -> tuple[Fork, ...]:
    """The forks on a route, with the road to take; `ends_m` are s, m, at the ends of its stretches.

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
    """The turn from one lane into another; "lane" where only one road goes on."""
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
