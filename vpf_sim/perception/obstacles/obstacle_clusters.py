"""Static obstacles from clusters of confirmed points: face, sides and identity."""

from collections.abc import Callable
from functools import partial

import numpy as np

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.obstacles import extent
from vpf_sim.perception.obstacles.clustering import clusters, split
from vpf_sim.perception.obstacles.extent import ObstaclePoints
from vpf_sim.perception.obstacles.low_obstacles import (
    belongs_to,
    extend_by_low,
    join,
    off_lines,
    widen,
    widen_to_tracks,
)
from vpf_sim.perception.obstacles.point_hypotheses import PointHypotheses, among
from vpf_sim.perception.obstacles.prediction import none
from vpf_sim.perception.obstacles.static_obstacle_settings import LowObstacleConfig, StaticObstacleConfig
from vpf_sim.types import Bools, Camera, Floats, Integers, Obstacles, RoadEdges

NONE: Integers = np.empty(0, np.int64)


class ObstacleClusters:
    """Groups confirmed points into obstacles, each with an identity that stays, and joins low tracks to them."""

    def __init__(self, camera: Camera, config: StaticObstacleConfig, points: PointHypotheses, window_px: int) -> None:
        self._camera, self._config, self._points = camera, config, points
        self._rim_rad = 0.5 * window_px / camera.fx_px
        self._next = 0
        self.fragments = NONE  # tracks of points that parted from an obstacle and are none

    def next_identity(self) -> int:
        self._next += 1
        return self._next - 1

    def obstacles(
        self, pose: Floats, road: RoadEdges, tracks: Obstacles, range_factor: float
    ) -> tuple[Obstacles, Obstacles]:
        """Tall obstacles; then all, with those of low points and low `tracks`. In vehicle axes at `pose`.

        `range_factor` is that of `StaticObstacleConfig`.
        """
        points, config = self._points, self._config
        low, alone, behind_m = config.low_obstacles, config.low_tracks, config.link_forward_m
        self.fragments = NONE
        tall = self._of_points(points.confirmed & ~points.low, config, self._are_tall, pose, road, range_factor)
        tall = widen(tall, np.maximum(tall.width_m + 2.0 * config.beside_m, config.least_width_m))
        found = tall
        if low is not None:
            flat = self._flat(tall, pose, road, low, range_factor)
            flat = widen_to_tracks(flat, tracks, low.parallax.along_m, low.beside_m)
            flat = widen(flat, config.low_tracks.least_width_m)
            found = extend_by_low(tall, flat, low.on_top.before_m, behind_m)
            sticks_out_m = np.minimum(low.sticks_out_m, low.sticks_out_share * found.width_m)
            found = join(found, flat, low.beside_m, sticks_out_m, low.before_m, behind_m)
        return tall, join(found, tracks, alone.beside_m, alone.sticks_out_m, alone.before_m, behind_m)

    def _flat(
        self, tall: Obstacles, pose: Floats, road: RoadEdges, low: LowObstacleConfig, range_factor: float
    ) -> Obstacles:
        """Obstacles of low points that belong to no tall one.

        A line may have become known after a point was observed: points of no obstacle yet must be off all lines.
        """
        points = self._points
        chosen = points.confirmed & points.low
        if not chosen.any():
            return none()
        place = vehicle_from_world(points.place_m, pose)
        parts = points.confirmed & ~points.low & (points.obstacle >= 0)
        chosen[chosen] = ~belongs_to(place[chosen], place[parts], points.obstacle[parts], tall, low.part)
        fresh = chosen & (points.obstacle < 0)
        chosen[fresh] = off_lines(self._camera, place[fresh], road, low)
        return self._of_points(chosen, low, partial(self._are_low, low), pose, road, range_factor)

    def _of_points(
        self,
        chosen: Bools,
        links: StaticObstacleConfig | LowObstacleConfig,
        are_obstacles: Callable[[Integers, Integers], Bools],
        pose: Floats,
        road: RoadEdges,
        range_factor: float,
    ) -> Obstacles:
        """The obstacles that the chosen points (M,) form."""
        rows, config = np.flatnonzero(chosen), self._config
        if not len(rows):
            return none()
        place, sigma = vehicle_from_world(self._points.place_m[rows], pose), self._points.sigma_m[rows]
        right_m = max(links.link_right_m, min(range_factor * links.link_right_m, config.link_most_m))
        near = partial(clusters, right_m=right_m, forward_m=links.link_forward_m, sigmas=config.sure_sigmas)
        label = near(place, sigma)
        accepted = are_obstacles(rows, label)
        if not accepted.any():
            return none()
        sight, rim = self._points.sight_rad[rows] - pose[2], self._points.depth_m[rows] * self._rim_rad
        seen, count = ObstaclePoints(place, sigma, sight, rim), len(accepted)
        angle, apart = extent.direction_at(seen, label, count, road), np.zeros(count, np.bool_)
        along = extent.rotate(seen, angle[label])
        behind = extent.is_behind(along, label, count, config.split, config.sure_sigmas)
        if behind.any():
            groups = np.full(len(rows), -1)
            groups[behind] = near(place[behind], sigma[behind])
            label, apart = split(label, groups, lambda parts: are_obstacles(rows, parts))
            accepted = are_obstacles(rows, label)
            angle = extent.direction_at(seen, label, len(apart), road)
            along = extent.rotate(seen, angle[label])
        return self._measure(rows, label, accepted, along, angle, apart, range_factor * config.reported_m)

    def _are_tall(self, rows: Integers, label: Integers) -> Bools:
        """(K,) clusters of points well above the road that are surely obstacles."""
        support, seeds = np.bincount(label), np.bincount(label, self._points.seed_weight[rows])
        together: Bools = (seeds >= 2) | ((seeds >= 1) & (support >= 3))
        return together

    def _are_low(self, config: LowObstacleConfig, rows: Integers, label: Integers) -> Bools:
        """(K,) clusters of low points that are surely obstacles."""
        margin = np.bincount(label, np.minimum(self._points.margin[rows], config.most_margin))
        together: Bools = (np.bincount(label) >= config.least_points) & (margin > config.least_margin)
        return together

    def _measure(
        self,
        rows: Integers,
        label: Integers,
        accepted: Bools,
        seen: ObstaclePoints,
        angle: Floats,
        apart: Bools,
        reported_m: float,
    ) -> Obstacles:
        """Identity, face and sides of the accepted clusters (K,); those `apart` were split from another.

        `seen` is turned by `angle` (K,), the road's direction: across the axes of a turned car the length of an
        obstacle would count as width.
        """
        points, config, count = self._points, self._config, len(accepted)
        face, face_sigma = extent.corrected_front(seen, label, count)
        placed = (face_sigma < config.face_sigma_m) & (face < reported_m)
        identity = self.identify(rows, label, accepted, placed, apart)
        accepted = accepted & (identity >= 0)
        across = extent.sides(seen, label, face, config.sharpest)
        face, left, right = extent.rotate_back(face, *across, angle)
        ahead = face - self._camera.forward_m
        part_of, support = np.where(accepted & ~apart, identity, -1), np.bincount(label)
        no_obstacle = extent.fragments(ahead, left, right, angle, part_of, support, config.fragment)
        self.fragments = np.concatenate([self.fragments, points.identity[rows[no_obstacle[label]]]])
        k = np.flatnonzero(accepted & ~no_obstacle)
        return Obstacles(face[k], left[k], right[k], face_sigma[k], np.full(len(k), np.inf), identity[k])

    def identify(self, rows: Integers, label: Integers, accepted: Bools, placed: Bools, apart: Bools) -> Integers:
        """(K,) identities of clusters: the one of their points, a new one if well placed, or else -1.

        A cluster `apart` does not keep the identity of the obstacle that it was split from, once it is well placed.
        One that keeps its own does not take that of another whose points, most of them elsewhere, joined it. One that
        is not well placed does not take the identity of an obstacle that it is a fragment of.
        """
        count, unknown = len(accepted), np.iinfo(np.int64).max
        before = self._points.obstacle[rows]
        known = np.where(before >= 0, before, unknown)
        others = apart[label] & among(known, known[(accepted & ~apart)[label]])
        own, identity, shared = np.full((3, count), unknown)
        np.minimum.at(own, label, np.where(others | ~_mostly_here(known, label, count), unknown, known))
        np.minimum.at(identity, label, np.where(others, unknown, known))
        np.minimum.at(shared, label, known)
        identity = np.where((own == unknown) & placed, identity, own)
        fresh = np.flatnonzero(accepted & placed & (identity == unknown))
        identity[fresh] = [self.next_identity() for _ in fresh]
        identity = np.where((identity == unknown) & apart, shared, identity)
        identity[identity == unknown] = -1
        self._points.obstacle[rows] = np.where(accepted[label], identity[label], before)
        return identity


def _mostly_here(identity: Integers, label: Integers, count: int) -> Bools:
    """(M,) points in the cluster, of `count`, that has most of the points of their identity."""
    _, index = np.unique(identity, return_inverse=True)
    points = np.bincount(index * count + label, minlength=(int(index.max()) + 1) * count).reshape(-1, count)
    here: Bools = points.argmax(axis=1)[index] == label
    return here
