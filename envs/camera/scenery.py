"""What stands beside the road, placed by a seed along the outer edges: posts, guard rails, signs, trees and bushes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vpf_sim.envs.camera.furniture import POST, SIGNS, rail
from vpf_sim.envs.camera.layout import LaneShape, outer_edges
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import Drawing, Sprite
from vpf_sim.envs.camera.roadside import Roadside, Standing
from vpf_sim.envs.camera.trees import TreeStand
from vpf_sim.envs.camera.veil import Veil
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

POST_SPACING_M, POST_OFFSET_M = 25.0, 1.3
RAIL_OFFSET_M, RAIL_SPAN_M = 1.7, 4.0
TREE_SPACING_M = 18.0
RANGE_M = 130.0


@dataclass(frozen=True, slots=True)
class Trees:
    """All trees of a road."""

    feet_m: Floats  # (T, 3) world
    heights_m: Floats  # (T,)
    variants: NDArray[np.int64]


class Scenery:
    """What stands beside a road and never moves."""

    def __init__(self, camera: Camera, shapes: list[LaneShape], light: Light, veil: Veil, seed: int) -> None:
        rng = stream(seed, "scenery")
        lanes = np.concatenate([0.5 * (shape.left_m + shape.right_m) for shape in shapes])
        half = max(0.5 * shape.width_m for shape in shapes)
        self._lanes, self._half = cKDTree(_dense(shapes, lanes)), half
        edges = [edge.resampled(RAIL_SPAN_M) for edge in outer_edges(shapes)]
        stations = [(edge.points_m, edge.outward) for edge in edges]
        things: list[Standing] = []
        for points, outward in stations:
            things += self._furniture(points, outward, rng)
        self._trees = self._plant(stations, rng)
        self._stand = TreeStand(light, veil)
        self._roadside = Roadside(camera, things, light, veil)

    def seen(self, view: View) -> tuple[Drawing | None, list[float]]:
        """The faces in view, the farthest thing first, and the depth of each, m."""
        return self._roadside.seen(view)

    def trees_seen(self, view: View) -> list[Sprite]:
        """The trees in view, the farthest first."""
        trees = self._trees
        return self._stand.seen(view, trees.feet_m, trees.heights_m, trees.variants)

    def _clear(self, points: Floats, margin_m: float) -> np.ndarray:
        """Which points are at least `margin_m` away from every lane."""
        distance, _ = self._lanes.query(points)
        return np.asarray(distance > self._half + margin_m - 0.3)

    def _furniture(self, points: Floats, outward: Floats, rng: np.random.Generator) -> list[Standing]:
        """Posts, and here and there a rail or a sign, along one edge sampled every 4 m."""
        result: list[Standing] = []
        every = round(POST_SPACING_M / RAIL_SPAN_M)
        heading = np.arctan2(*(points[-1] - points[0])[::-1]) if len(points) > 1 else 0.0
        along = np.arctan2(outward[:, 1], outward[:, 0])
        railed = _railed(len(points), rng)
        places = points + POST_OFFSET_M * outward
        free = self._clear(places, POST_OFFSET_M)
        turned = np.sign(np.sin(along - heading))
        facing = along - turned * np.pi / 2  # back along the lane
        standing = np.flatnonzero(free & ~railed & (np.arange(len(points)) % every == 0))
        result += [(POST, np.array([*places[i], facing[i]]), RANGE_M) for i in standing]
        places = points + RAIL_OFFSET_M * outward
        clear = self._clear(places, RAIL_OFFSET_M)
        for i in np.flatnonzero(railed[:-1] & railed[1:] & clear[:-1] & clear[1:]).tolist():
            span = places[i + 1] - places[i]
            result.append(
                (rail(round(float(np.hypot(*span)), 2)), np.array([*places[i], np.arctan2(span[1], span[0])]), RANGE_M)
            )
        for i in range(int(rng.integers(10, 40)), len(points), 45):
            place = points[i] + 2.6 * outward[i]
            if self._clear(place[None], 2.6)[0]:
                sign = SIGNS[int(rng.integers(len(SIGNS)))]
                result.append((sign, np.array([*place, facing[i]]), RANGE_M))
        return result

    def _plant(self, stations: list[tuple[Floats, Floats]], rng: np.random.Generator) -> Trees:
        feet = []
        for points, outward in stations:
            every = max(1, round(TREE_SPACING_M / RAIL_SPAN_M))
            base, out = points[::every], outward[::every]
            reach = 5.5 + 26.0 * rng.random(len(base)) ** 1.6
            place = base + reach[:, None] * out + rng.uniform(-4.0, 4.0, (len(base), 2))
            feet.append(place[self._clear(place, 4.0) & (rng.random(len(base)) < 0.75)])
        all_feet = np.concatenate([np.empty((0, 2)), *feet])
        variants = rng.integers(0, 8, len(all_feet))
        tall = np.array([9.5, 8.0, 12.0, 2.4])[variants % 4] * rng.uniform(0.7, 1.25, len(all_feet))
        return Trees(np.column_stack([all_feet, np.zeros(len(all_feet))]), tall, variants)


def _dense(shapes: list[LaneShape], fallback: Floats) -> Floats:
    """Points on the middles of all lanes, at most 2 m apart."""
    points = [fallback]
    for shape in shapes:
        middle = 0.5 * (shape.left_m + shape.right_m)
        steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        s = np.arange(0.0, along[-1], 2.0)
        points.append(np.stack([np.interp(s, along, middle[:, i]) for i in range(2)], axis=1))
    return np.concatenate(points)


def _railed(count: int, rng: np.random.Generator) -> np.ndarray:
    """Which stations have a guard rail: stretches of 40 to 160 m, about a third of the way."""
    flags = np.zeros(count, bool)
    i = int(rng.integers(0, 40))
    while i < count:
        length = int(rng.integers(10, 40))
        flags[i : i + length] = True
        i += length + int(rng.integers(20, 70))
    return flags
