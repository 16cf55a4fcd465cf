"""Which lanes of a highway-env network a route uses, from the ego's start to its destination and beyond.

A road is a pair of nodes (from, to) with parallel lanes. Lanes are named as in highway-env: (from, to, number).
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import hypot, pi
from typing import Any

import numpy as np
from highway_env.road.lane import AbstractLane
from highway_env.road.road import LaneIndex, RoadNetwork
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats

Road = tuple[str, str]
LEADS_ON_M = 3.0  # a lane leads into another if its end is nearer to it
SHARPEST_RAD = pi / 3.0  # change of heading from a road to one that continues it
SHORTEST_M = 1.0  # a lane of which less would be used is left out
NEAR_M = 120.0  # part of the line, before and after a known place, that is searched
NEWTON_STEPS = 6


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


class SplineLine:
    """A `ReferenceLine` through points (N, 2) m that are about a metre apart.

    The spline is twice continuously differentiable, and its parameter is the length of the chords: over a metre of an
    arc of radius R the chord is 1 / (24 R^2) m shorter than the arc.
    """

    def __init__(self, points_m: Floats) -> None:
        self._s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points_m, axis=0).T))])
        self._points = points_m
        self.length_m = float(self._s[-1])
        spline = CubicSpline(self._s, points_m)
        self._spline, self._slope, self._bend = spline, spline.derivative(), spline.derivative(2)
        self._pieces: Any = spline.c.transpose(1, 2, 0).tolist()  # floats by piece, axis, power
        self._starts: list[float] = self._s.tolist()

    def position(self, s_m: ArrayLike, lateral_m: ArrayLike = 0.0) -> Floats:
        """(..., 2) m, the world points at s along the line and `lateral` right of it."""
        s, lateral = np.broadcast_arrays(np.asarray(s_m, float), np.asarray(lateral_m, float))
        on_line = np.clip(s, 0.0, self.length_m)
        heading = self.heading(s)
        along, right = (
            np.stack([np.cos(heading), np.sin(heading)], -1),
            np.stack([-np.sin(heading), np.cos(heading)], -1),
        )
        placed: Floats = self._spline(on_line) + (s - on_line)[..., None] * along + lateral[..., None] * right
        return placed

    def heading(self, s_m: ArrayLike) -> Floats:
        """(...) rad in (-pi, pi]."""
        slope = self._slope(np.clip(np.asarray(s_m, float), 0.0, self.length_m))
        return np.asarray(np.arctan2(slope[..., 1], slope[..., 0]))

    def curvature(self, s_m: ArrayLike) -> Floats:
        """(...) 1/m, > 0 turns right; 0 beyond both ends."""
        s = np.asarray(s_m, float)
        on_line = np.clip(s, 0.0, self.length_m)
        slope, bend = self._slope(on_line), self._bend(on_line)
        turn = slope[..., 0] * bend[..., 1] - slope[..., 1] * bend[..., 0]
        curvature = turn / np.hypot(slope[..., 0], slope[..., 1]) ** 3
        return np.asarray(np.where(s == on_line, curvature, 0.0))

    def position_at(self, s_m: float, lateral_m: float) -> tuple[float, float]:
        """`position` of one point."""
        x, y = self.position(s_m, lateral_m).tolist()
        return x, y

    def heading_at(self, s_m: float) -> float:
        """`heading` at one s."""
        return float(self.heading(s_m))

    def local_at(self, x_m: float, y_m: float, near_m: float | None = None) -> tuple[float, float]:
        """The inverse of `position`: (s, lateral) m of a world point.

        With `near_m` only that part of the line is searched; without, all of it. This matters where the line crosses
        itself or runs beside itself, as on a second lap.
        """
        s = self._nearest_knot(x_m, y_m, near_m)
        for _ in range(NEWTON_STEPS):
            x, y, dx, dy, ddx, ddy = self._state(s)
            away_x, away_y = x_m - x, y_m - y
            slope = max(dx * dx + dy * dy - away_x * ddx - away_y * ddy, 0.1)
            before, s = s, min(max(s + (away_x * dx + away_y * dy) / slope, 0.0), self.length_m)
            if abs(s - before) < 1e-9:
                break
        x, y, dx, dy, *_ = self._state(s)
        heading_x, heading_y = dx / hypot(dx, dy), dy / hypot(dx, dy)
        beyond = heading_x * (x_m - x) + heading_y * (y_m - y) if s in (0.0, self.length_m) else 0.0
        return s + beyond, heading_x * (y_m - y) - heading_y * (x_m - x)

    def _nearest_knot(self, x_m: float, y_m: float, near_m: float | None) -> float:
        """The s of the knot nearest to a point."""
        first, last = 0, len(self._starts)
        if near_m is not None:
            first = min(bisect_left(self._starts, near_m - NEAR_M), last - 2)
            last = max(bisect_left(self._starts, near_m + NEAR_M), first + 2)
        away = self._points[first:last] - (x_m, y_m)
        return self._starts[first + int(np.argmin(np.einsum("ij,ij->i", away, away)))]

    def _state(self, s: float) -> tuple[float, float, float, float, float, float]:
        """x, y and their first and second derivatives at s on the line, in plain floats for speed."""
        index = min(bisect_right(self._starts, s) - 1, len(self._pieces) - 1)
        v = s - self._starts[index]
        (a, b, c, x), (e, f, g, y) = self._pieces[index]
        return (
            ((a * v + b) * v + c) * v + x,
            ((e * v + f) * v + g) * v + y,
            (3.0 * a * v + 2.0 * b) * v + c,
            (3.0 * e * v + 2.0 * f) * v + g,
            6.0 * a * v + 2.0 * b,
            6.0 * e * v + 2.0 * f,
        )
