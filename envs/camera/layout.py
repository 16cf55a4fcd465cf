"""A highway-env road as polylines: both edges of each lane, sampled once.

Only `position`, `heading_at`, `width_at`, `length`, `line_types` and, on our own roads, `oncoming` of the lanes are
read. A lateral position on a lane interpolates between its edges. Lanes at the network's ends are extended straight,
out of sight.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from highway_env.road.lane import AbstractLane, LineType
from highway_env.road.road import Road, RoadNetwork
from scipy.spatial import cKDTree

from vpf_sim.geometry import unwrapped
from vpf_sim.types import Bools, Floats

SAGITTA_M = 0.01  # largest deviation of a chord between two samples from the arc
SHORTEST_STEP_M, STRAIGHT_STEP_M = 0.5, 8.0
PROBES = 64  # samples of a lane's heading
RUN_ON_M = 300.0  # extension of lanes beyond the network's ends
CRACK_M = (0.001, 0.3)  # between two lanes: racetrack-v0 has one of 0.09 m
SAME_WIDTH_M = 0.001
SAME_LINE_M = 0.4  # lines nearer than this are the same line
ROADS = 16  # whose lines and edges are kept


@dataclass(frozen=True)
class LaneShape:
    """The edges of one lane at stations s."""

    s_m: Floats  # (M,) along the lane, < 0 and > length on its extensions
    left_m: Floats  # (M, 2) world
    right_m: Floats  # (M, 2)
    line_types: tuple[int, int]  # highway_env.road.lane.LineType of the left and the right edge
    oncoming: bool = False  # whether it is driven against s

    @property
    def as_driven(self) -> "LaneShape":
        """The lane with s in the direction that it is driven in: -s in a lane of oncoming traffic."""
        if not self.oncoming:
            return self
        return LaneShape(-self.s_m[::-1], self.right_m[::-1], self.left_m[::-1], self.line_types[::-1])

    def at(self, lateral_m: float | Floats) -> Floats:
        """(M, 2) world points `lateral_m` to the right of the centre line."""
        across = self.right_m - self.left_m
        width = np.linalg.norm(across, axis=1)
        share = 0.5 + np.asarray(lateral_m) / width
        return np.asarray(self.left_m + share[:, None] * across)

    def points(self, s_m: Floats, lateral_m: Floats) -> Floats:
        """(..., 2) world points at stations s, `lateral_m` to the right of the centre line."""
        left, right = (interpolated(s_m, self.s_m, edge) for edge in (self.left_m, self.right_m))
        return np.asarray(left + (0.5 + lateral_m / self.width_m)[..., None] * (right - left))

    @cached_property
    def width_m(self) -> float:
        """The median width."""
        return float(np.median(np.linalg.norm(self.right_m - self.left_m, axis=1)))

    @property
    def width_range_m(self) -> tuple[float, float]:
        """The least and the largest width; twice the median where they differ by rounding."""
        widths, median = np.linalg.norm(self.right_m - self.left_m, axis=1), self.width_m
        low, high = float(widths.min()), float(widths.max())
        return (low, high) if high - low > SAME_WIDTH_M else (median, median)


@dataclass(frozen=True, slots=True)
class Line:
    """A marking between or beside lanes."""

    s_m: Floats  # (M,)
    points_m: Floats  # (M, 2) of its middle
    striped: bool


def lane_shapes(road: Road) -> list[LaneShape]:
    """Every lane of the network. Those of a scenario's road are made once for its settings (`network.road`)."""
    if getattr(road.network, "road", None) is None:
        return _all_sampled(road.network)
    return list(_shapes(_Settings(road.network)))


class _Settings:
    """The network of a scenario's road as a key: equal where the road's settings are."""

    def __init__(self, network: RoadNetwork) -> None:
        self.network = network

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Settings) and bool(self.network.road == other.network.road)

    def __hash__(self) -> int:
        return hash(self.network.road)


@lru_cache(maxsize=ROADS)
def _shapes(road: _Settings) -> list[LaneShape]:
    return _all_sampled(road.network)


def _all_sampled(network: RoadNetwork) -> list[LaneShape]:
    graph = network.graph
    reached = {end for ends in graph.values() for end in ends}
    return [
        _sampled(lane, beside, before=start not in reached, after=not graph.get(end))
        for start, ends in graph.items()
        for end, lanes in ends.items()
        for beside, lane in pairwise([None, *lanes])
        if lane is not None
    ]


class Geometry:
    """The shapes of a road as a key: equal where all their numbers are."""

    def __init__(self, shapes: list[LaneShape]) -> None:
        self.shapes = shapes
        self._key = tuple((s.s_m.tobytes(), s.left_m.tobytes(), s.right_m.tobytes(), s.line_types) for s in shapes)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Geometry) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def lines(shapes: list[LaneShape]) -> list[Line]:
    """The markings of the lanes; a line shared by two lanes is listed once. Cached: a road is drawn by many seeds."""
    return list(_lines(Geometry(shapes)))


@lru_cache(maxsize=ROADS)
def _lines(road: Geometry) -> list[Line]:
    kept: list[Line] = []
    drawn: list[cKDTree] = []
    for shape in road.shapes:
        for edge, kind in zip((shape.left_m, shape.right_m), shape.line_types, strict=True):
            if kind == LineType.NONE or _covered(points := _resampled(edge), drawn):
                continue
            kept.append(Line(shape.s_m, edge, striped=kind == LineType.STRIPED))
            drawn.append(cKDTree(points, balanced_tree=False))
    return kept


def interpolated(s: Floats, stations: Floats, points: Floats) -> Floats:
    """(..., 2) points of a polyline (M, 2) at stations s of any shape."""
    return np.stack([np.interp(s, stations, points[:, i]) for i in range(2)], axis=-1)


def stations_m(points_m: Floats) -> Floats:
    """(M,) m, distances along a polyline (M, 2) from its first point."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points_m, axis=0), axis=1))])


def stripes(line: Line, stripe_m: float, gap_m: float) -> Floats:
    """(n, 2) m, start and end of each stripe along a striped line."""
    period_m = stripe_m + gap_m
    first, last = line.s_m[0], line.s_m[-1]
    starts = np.arange(np.ceil(first / period_m), np.floor((last - stripe_m) / period_m) + 1) * period_m
    return np.stack([starts, starts + stripe_m], axis=1)


@dataclass(frozen=True, slots=True)
class Edge:
    """A stretch of a lane's edge beyond which there is no other lane."""

    points_m: Floats  # (M, 2) world, in the direction of the lane
    outward: Floats  # (M, 2) unit normals away from the lane

    def at(self, outward_m: float | Floats) -> Floats:
        """(M, 2) world points outside the edge, at a distance or at (M, 1) distances."""
        return self.points_m + outward_m * self.outward

    def resampled(self, step_m: float) -> "Edge":
        """The edge with points `step_m` apart."""
        along = stations_m(self.points_m)
        s = np.linspace(0.0, along[-1], max(2, round(along[-1] / step_m) + 1))
        outward = interpolated(s, along, self.outward)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        return Edge(interpolated(s, along, self.points_m), outward)


def outer_edges(shapes: list[LaneShape]) -> list[Edge]:
    """The outer edges of the carriageway, in stretches along one lane each. Cached, as `lines` are."""
    return list(_outer_edges(Geometry(shapes)))


@lru_cache(maxsize=ROADS)
def _outer_edges(road: Geometry) -> list[Edge]:
    edges, shapes = [], road.shapes
    strips = [_Strip.of(shape) for shape in shapes]
    for shape, strip in zip(shapes, strips, strict=True):
        across = shape.right_m - shape.left_m
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        others = [other for other in strips if other is not strip]
        for points, outward in ((shape.left_m, -across), (shape.right_m, across)):
            outside = points + 0.5 * outward
            free = ~np.logical_or.reduce([np.zeros(len(points), bool), *(other.holds(outside) for other in others)])
            edges += [Edge(points[run], outward[run]) for run in _runs(free)]
    return edges


@dataclass(frozen=True, slots=True)
class _Strip:
    """The surface of a lane as straight pieces."""

    start_m: Floats  # (M - 1, 2) first points on the lane's middle
    unit: Floats  # (M - 1, 2) directions
    length_m: Floats  # (M - 1,)
    half_m: Floats  # (M,) half the lane's width at their ends
    middles: cKDTree

    @classmethod
    def of(cls, shape: LaneShape) -> "_Strip":
        middle = 0.5 * (shape.left_m + shape.right_m)
        start, along = middle[:-1], np.diff(middle, axis=0)
        length = np.linalg.norm(along, axis=1)
        half = 0.5 * np.linalg.norm(shape.right_m - shape.left_m, axis=1)
        return cls(start, along / length[:, None], length, half, cKDTree(0.5 * (start + middle[1:])))

    def holds(self, points: Floats) -> Bools:
        """(N,) whether points (N, 2) lie on the lane."""
        last = len(self.start_m) - 1
        nearest = self.middles.query(points)[1]
        on = np.zeros(len(points), bool)
        # the piece with the nearest middle or a neighbour, since pieces differ in length
        for index in (np.maximum(nearest - 1, 0), nearest, np.minimum(nearest + 1, last)):
            relative, unit = points - self.start_m[index], self.unit[index]
            s = np.einsum("ij,ij->i", relative, unit)
            lateral = relative[:, 1] * unit[:, 0] - relative[:, 0] * unit[:, 1]
            on |= (s > -0.1) & (s < self.length_m[index] + 0.1) & (np.abs(lateral) <= self.half_m[index])
        return on


def _runs(flags: Bools) -> list[slice]:
    """Slices of runs of at least two true flags, extended by one sample at either end."""
    padded = np.concatenate([[False], flags, [False]]).astype(np.int8)
    starts, ends = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    return [
        slice(max(0, int(a) - 1), min(len(flags), int(b) + 1)) for a, b in zip(starts, ends, strict=True) if b - a >= 2
    ]


def _sampled(lane: AbstractLane, beside: AbstractLane | None, before: bool, after: bool) -> LaneShape:
    """A lane's shape; `beside` is the lane on its left."""
    length = float(lane.length)
    s = _stations(lane, length)
    half = np.array([0.5 * lane.width_at(float(x)) for x in s])
    left = np.array([lane.position(float(x), -w) for x, w in zip(s, half, strict=True)], float)
    right = np.array([lane.position(float(x), w) for x, w in zip(s, half, strict=True)], float)
    if beside is not None:
        left = np.array([_closed(point, beside) for point in left], float)
    beyond = np.arange(STRAIGHT_STEP_M, RUN_ON_M, STRAIGHT_STEP_M)
    if before:
        direction = _direction(lane, 0.0)
        back = beyond[::-1, None] * direction
        s = np.concatenate([-beyond[::-1], s])
        left, right = np.concatenate([left[0] - back, left]), np.concatenate([right[0] - back, right])
    if after:
        onward = beyond[:, None] * _direction(lane, length)
        s = np.concatenate([s, length + beyond])
        left, right = np.concatenate([left, left[-1] + onward]), np.concatenate([right, right[-1] + onward])
    kinds = int(lane.line_types[0]), int(lane.line_types[1])
    return LaneShape(s, left, right, kinds, getattr(lane, "oncoming", False))


def _closed(point: Floats, beside: AbstractLane) -> Floats:
    """A point of a lane's left edge, moved to the lane beside it over a gap that is an inaccuracy of the network."""
    along, lateral = beside.local_coordinates(point)
    half = 0.5 * beside.width_at(along)
    if not (0.0 <= along <= beside.length and CRACK_M[0] < lateral - half < CRACK_M[1]):
        return point
    met: Floats = beside.position(along, half)
    return met


def _stations(lane: AbstractLane, length: float) -> Floats:
    """Stations along a lane, dense enough for its sharpest bend.

    The sagitta of a chord c at curvature k is c^2 k / 8.
    """
    spacing = length / PROBES
    headings = unwrapped([lane.heading_at(spacing * i) for i in range(PROBES + 1)])
    sharpest = float(np.abs(np.diff(headings)).max()) / spacing
    step = np.sqrt(8.0 * SAGITTA_M / max(sharpest, 1e-9))
    count = max(2, int(np.ceil(length / np.clip(step, SHORTEST_STEP_M, STRAIGHT_STEP_M))) + 1)
    knots = getattr(lane, "knots_m", np.empty(0))  # of a width that is linear in between
    return np.union1d(np.linspace(0.0, length, count), knots[(knots > 0.0) & (knots < length)])


def _direction(lane: AbstractLane, s: float) -> Floats:
    heading = lane.heading_at(s)
    return np.array([np.cos(heading), np.sin(heading)])


def _covered(points: Floats, drawn: list[cKDTree]) -> bool:
    """Whether most points of an edge lie on lines listed already."""
    near = np.zeros(len(points), bool)
    low, high = points.min(axis=0) - SAME_LINE_M, points.max(axis=0) + SAME_LINE_M
    for line in drawn:
        if (line.mins <= high).all() and (low <= line.maxes).all():
            near |= np.isfinite(line.query(points, distance_upper_bound=SAME_LINE_M)[0])
    return bool(np.mean(near) > 0.5)


def _resampled(points: Floats, step_m: float = 0.5) -> Floats:
    along = stations_m(points)
    stations = np.arange(0.0, along[-1], step_m)
    return np.stack([np.interp(stations, along, points[:, i]) for i in range(2)], axis=1)
