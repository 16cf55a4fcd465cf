"""Placement of road furniture along the outer edges of a road, by a seed."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from vpf_sim.envs.camera.layout import ROADS, Edge, Geometry, LaneShape, outer_edges
from vpf_sim.envs.camera.scenery.furniture import LAMP_M, LAMP_POST, POST, gantry, rail
from vpf_sim.envs.camera.scenery.roadside import Placement
from vpf_sim.envs.camera.scenery.signs import SIGNS, chevron
from vpf_sim.geometry import unwrapped
from vpf_sim.types import Bools, Floats

STATION_M = 4.0  # sampling of the edges
POST_EVERY, POST_OFFSET_M = 6, 1.3  # stations
RAIL_EVERY, RAIL_OFFSET_M = 3, 1.7
SIGN_EVERY, SIGN_OFFSET_M = 16, 2.6
LAMP_EVERY, LAMP_OFFSET_M = 10, 2.4
LIT_SHARE = 0.5  # share of roads with lamp posts
GANTRY_EVERY, GANTRY_OFFSET_M = 60, 2.0
WIDEST_M = 40.0  # widest gantry
CHEVRON_EVERY, BEND_M = 8, 250.0  # bends of smaller radius have chevrons
POST_RANGE_M, RAIL_RANGE_M, SIGN_RANGE_M, TALL_RANGE_M = 100.0, 110.0, 130.0, 200.0


@dataclass(frozen=True, slots=True)
class Side:
    """An outer edge of the road at its stations."""

    points_m: Floats  # (n, 2)
    outward: Floats  # (n, 2) unit
    heading: Floats  # (n,) rad, of the lane beside it
    to_right: bool  # whether outward is right of the lane
    curvature: Floats  # (n,) 1/m, > 0 turns right

    def pose(self, index: int, offset_m: float, turn: float = 0.0) -> Floats:
        """Pose (x, y, heading) outside the edge, facing traffic in the lane."""
        return np.array([*(self.points_m[index] + offset_m * self.outward[index]), self.heading[index] + turn])


class Verge:
    """The strips of ground beside a road."""

    @staticmethod
    @lru_cache(maxsize=ROADS)
    def of(road: Geometry) -> "Verge":
        """The verge of a road. Cached: a road is drawn by many seeds."""
        return Verge(road.shapes)

    def __init__(self, shapes: list[LaneShape]) -> None:
        self._lanes = cKDTree(np.concatenate([_dense(shape) for shape in shapes]))
        self._half = max(0.5 * shape.width_range_m[1] for shape in shapes)
        self._middles = [_dense(shape) for shape in shapes]
        self.sides = [_side(edge.points_m, edge.outward) for edge in map(_stations, outer_edges(shapes))]

    def clear(self, points: Floats, margin_m: float) -> Bools:
        """Which points are at least `margin_m` from every lane."""
        distance, _ = self._lanes.query(points)
        return np.asarray(distance > self._half + margin_m - 0.3)

    def furniture(self, rng: np.random.Generator) -> list[Placement]:
        """All furniture of the road."""
        lit, items = rng.random() < LIT_SHARE, []
        for side in self.sides:
            railed = _railed(len(side.points_m), rng)
            items += [*self._posts(side, railed), *self._rails(side, railed), *self._signs(side, rng)]
            if lit and side.to_right:
                items += self._lamps(side, int(rng.integers(LAMP_EVERY)))
            if side.to_right:
                items += self._gantries(side, rng)
        return items

    def _every(self, side: Side, first: int, step: int, offset_m: float) -> Iterator[int]:
        """Stations with free ground at an offset."""
        free = self.clear(side.points_m + offset_m * side.outward, offset_m)
        return iter([i for i in range(first, len(side.points_m), step) if free[i]])

    def _posts(self, side: Side, railed: Bools) -> Iterator[Placement]:
        for i in self._every(side, 0, POST_EVERY, POST_OFFSET_M):
            if not railed[i]:
                yield POST, side.pose(i, POST_OFFSET_M), POST_RANGE_M

    def _rails(self, side: Side, railed: Bools) -> Iterator[Placement]:
        places = side.points_m + RAIL_OFFSET_M * side.outward
        standing = railed & self.clear(places, RAIL_OFFSET_M)
        for i in range(0, len(places) - RAIL_EVERY, RAIL_EVERY):
            if standing[i : i + RAIL_EVERY + 1].all():
                start, end = places[i], places[i + RAIL_EVERY]
                along = end - start
                pose = np.array([*(0.5 * (start + end)), np.arctan2(along[1], along[0])])
                yield rail(round(float(np.hypot(*along)), 2)), pose, RAIL_RANGE_M

    def _signs(self, side: Side, rng: np.random.Generator) -> Iterator[Placement]:
        for i in self._every(side, int(rng.integers(4, SIGN_EVERY)), SIGN_EVERY, SIGN_OFFSET_M):
            if side.to_right or rng.random() < 0.3:
                yield SIGNS[int(rng.integers(len(SIGNS)))], side.pose(i, SIGN_OFFSET_M), SIGN_RANGE_M
        for i in self._every(side, 2, CHEVRON_EVERY, POST_OFFSET_M):
            bends = float(side.curvature[i])
            if abs(bends) > 1.0 / BEND_M and (bends < 0.0) == side.to_right and rng.random() < 0.3:
                yield chevron(3, not side.to_right), side.pose(i, SIGN_OFFSET_M), SIGN_RANGE_M

    def _lamps(self, side: Side, first: int) -> Iterator[Placement]:
        for i in self._every(side, first, LAMP_EVERY, LAMP_OFFSET_M):
            for mesh in LAMP_POST:
                yield mesh, side.pose(i, LAMP_OFFSET_M), TALL_RANGE_M

    def _gantries(self, side: Side, rng: np.random.Generator) -> Iterator[Placement]:
        """Gantries over the whole road, where the opposite edge is straight across."""
        for i in range(int(rng.integers(10, GANTRY_EVERY)), len(side.points_m), GANTRY_EVERY):
            across = -side.outward[i]
            start = side.points_m[i] + GANTRY_OFFSET_M * side.outward[i]
            width = self._width(side.points_m[i], across)
            if width is None:
                continue
            span = width + 2.0 * GANTRY_OFFSET_M
            if self.clear(np.array([start, start + span * across]), GANTRY_OFFSET_M - 0.2).all():
                middle = start + 0.5 * span * across
                lanes = self._lanes_across(side.points_m[i], across, width)
                pose = np.array([*middle, side.heading[i]])
                for mesh in gantry(span, tuple(0.5 * width - y for y in lanes), int(rng.integers(9))):
                    yield mesh, pose, TALL_RANGE_M

    def _width(self, point: Floats, across: Floats) -> float | None:
        """Distance of the opposite edge straight across, m; None without one."""
        for other in self.sides:
            relative = other.points_m - point
            along, aside = relative @ across, relative @ (-across[1], across[0])
            k = int(np.argmin(np.abs(aside)))
            if abs(aside[k]) < STATION_M and 5.0 < along[k] < WIDEST_M and other.outward[k] @ across > 0.9:
                return float(along[k])
        return None

    def _lanes_across(self, point: Floats, across: Floats, width: float) -> list[float]:
        """Distances of the lanes' middles across from an edge, m."""
        result = []
        for middle in self._middles:
            relative = middle - point
            along, aside = relative @ across, np.abs(relative @ (-across[1], across[0]))
            k = int(np.argmin(aside))
            if aside[k] < STATION_M and 0.0 < along[k] < width:
                result.append(float(along[k]))
        return sorted(result)


def lamp_places(furniture: list[Placement]) -> Floats:
    """(n, 3) m, world positions of the lamps of the lamp posts among the furniture."""
    poses = np.array([pose for mesh, pose, _ in furniture if mesh is LAMP_POST[-1]]).reshape(-1, 3)
    x, y, heading = poses.T
    aside, height = LAMP_M
    return np.stack([x - aside * np.sin(heading), y + aside * np.cos(heading), np.full(len(x), height)], axis=1)


def _stations(edge: Edge) -> Edge:
    return edge.resampled(STATION_M)


def _side(points: Floats, outward: Floats) -> Side:
    along = np.gradient(points, axis=0)
    heading = unwrapped(np.arctan2(along[:, 1], along[:, 0]))
    to_right = bool(np.mean(along[:, 0] * outward[:, 1] - along[:, 1] * outward[:, 0]) > 0.0)
    return Side(points, outward, heading, to_right, np.gradient(heading) / STATION_M)


def _dense(shape: LaneShape) -> Floats:
    """Points on the middle of a lane, at most 2 m apart."""
    middle = 0.5 * (shape.left_m + shape.right_m)
    steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    s = np.arange(0.0, along[-1], 2.0)
    between = np.stack([np.interp(s, along, middle[:, i]) for i in range(2)], axis=1)
    return np.concatenate([middle, between])


def _railed(count: int, rng: np.random.Generator) -> Bools:
    """Which stations have a guard rail: stretches of 40 to 160 m, about a third of the road."""
    flags = np.zeros(count, bool)
    i = int(rng.integers(0, 40))
    while i < count:
        length = int(rng.integers(10, 40))
        flags[i : i + length] = True
        i += length + int(rng.integers(20, 70))
    return flags
