"""Bodies that believed points make together: their face, their sides and their names."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.obstacles.clustering import clusters, stepped
from vpf_sim.perception.obstacles.config import LowObstacleConfig, StaticObstacleConfig
from vpf_sim.perception.obstacles.extent import (
    Seen,
    direction_at,
    face_of,
    joined,
    nearest_spot,
    nearest_sure,
    none,
    on_top,
    outdated,
    parted,
    sides,
    stands_behind,
    strays,
    turned,
    turned_back,
    widened,
    widened_to_observation,
)
from vpf_sim.perception.obstacles.low_obstacles import belongs_to, in_shadow, off_lines
from vpf_sim.perception.obstacles.point_hypotheses import Integers, PointHypotheses, among, frames
from vpf_sim.types import Bools, Camera, Floats, Obstacles, RoadEdges


class Bodies:
    """What the believed points of `marks` and what was seen low on the road tell of bodies, each under one name."""

    def __init__(self, camera: Camera, config: StaticObstacleConfig, marks: PointHypotheses, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self._points = marks
        self._rate_hz = rate_hz  # of judging points
        self._next = 0
        self.cross_confirmed: Integers = np.empty(
            0, np.int64
        )  # identities of low bodies that points and spots tell of both
        self.parts: Integers = np.empty(0, np.int64)  # tracks whose points parted from a body and are none
        self.gone: Integers = np.empty(0, np.int64)  # tracks of bodies that were high up and not seen any nearer

    def number(self) -> int:
        """The name of a new body."""
        self._next += 1
        return self._next - 1

    def told(self, pose: Floats, road: RoadEdges, seen: Obstacles) -> tuple[Obstacles, Obstacles]:
        """Those of points well above the road; then all, with those of low points and those `seen` low on the road.

        All are in the axes of the vehicle at `pose`.
        """
        marks, low = self._points, self.config.low_obstacles
        self.parts = self.gone = self.parts[:0]
        tall = self._of_points(marks.believed & ~marks.low, self.config, self._are_tall, pose, road)
        tall = widened(tall, np.maximum(tall.width_m + 2.0 * self.config.beside_m, self.config.least_width_m))
        spots = self.config.spots
        if low is None:
            return tall, joined(tall, seen, spots.beside_m, spots.sticks_out_m, spots.before_m)
        flat = self._flat(tall, pose, road, low)
        self.cross_confirmed = self.cross_confirmed[:0]
        if low.parallax is not None:
            nearest, both = nearest_spot(flat, seen, low.parallax.along_m, low.beside_m)
            if low.parallax.verified is not None:
                self.cross_confirmed = flat.identity[both]
            if low.parallax.width is not None:
                flat = widened_to_observation(flat, seen, nearest, both)
        flat = widened(flat, low.least_width_m)
        whole = on_top(tall, flat, low.on_top.before_m) if low.on_top else tall
        sticks_out_m = np.minimum(low.sticks_out_m, low.sticks_out_share * whole.width_m)
        bodies = joined(whole, flat, low.beside_m, sticks_out_m, low.before_m)
        return tall, joined(bodies, seen, spots.beside_m, spots.sticks_out_m, spots.before_m)

    def _flat(self, tall: Obstacles, pose: Floats, road: RoadEdges, low: LowObstacleConfig) -> Obstacles:
        """Those of low points that are neither of the taller bodies told nor of their shadows, nor paint.

        Lines that were not known when a point was seen may be by now: one that lies on them tells no new body.
        """
        marks = self._points
        chosen = marks.believed & marks.low
        if not chosen.any():
            return none()
        place, parts = vehicle_from_world(marks.place_m, pose), marks.believed & ~marks.low & (marks.body >= 0)
        if low.part is not None:
            chosen[chosen] = ~belongs_to(place[chosen], place[parts], marks.body[parts], tall, low.part)
        fresh = chosen & (marks.body < 0)
        chosen[fresh] = off_lines(self.camera, place[fresh], road, low)
        shaded = in_shadow(place, tall, low.shadow) if low.shadow else np.zeros(len(place), np.bool_)

        def are_bodies(believed: Integers, label: Integers) -> Bools:
            return self._are_low(believed, label, shaded[believed], low)

        return self._of_points(chosen, low, are_bodies, pose, road)

    def _of_points(
        self,
        chosen: Bools,
        links: StaticObstacleConfig | LowObstacleConfig,
        are_bodies: Callable[[Integers, Integers], Bools],
        pose: Floats,
        road: RoadEdges,
    ) -> Obstacles:
        """The bodies that the chosen points (M,) make together."""
        believed = np.flatnonzero(chosen)
        if not len(believed):
            return none()
        place = vehicle_from_world(self._points.place_m[believed], pose)
        sigma = self._points.sigma_m[believed]
        label = clusters(place, sigma, links.link_right_m, links.link_forward_m)
        confirmed = are_bodies(believed, label)
        if not confirmed.any():  # nor is any part of them one
            return none()
        rim = 0.5 * self.config.window_px / self.camera.fx_px * self._points.depth_m[believed]
        sight, alone = self._points.sight_rad[believed] - pose[2], are_bodies(believed, np.arange(len(believed)))
        seen, count = Seen(place, sigma, sight, rim, alone, np.zeros(len(label), np.bool_)), int(label.max()) + 1
        angle, apart = direction_at(seen, label, count, road), np.zeros(count, np.bool_)
        along = turned(seen, angle[label])
        split = self.config.split
        behind = stands_behind(along, label, count, split) if split else np.zeros(len(label), np.bool_)
        if split and behind.any():
            groups = np.full(len(label), -1)
            groups[behind] = clusters(place[behind], sigma[behind], links.link_right_m, links.link_forward_m)
            if split.outlier:
                seen = replace(seen, stray=strays(seen, groups, split.outlier.sigma_m))
            label, apart = stepped(label, groups, lambda parts: are_bodies(believed, parts))
            confirmed = are_bodies(believed, label)
            angle = direction_at(seen, label, len(apart), road)
            along = turned(seen, angle[label])
        return self._describe(believed, label, confirmed, along, angle, apart, self._came_near(believed, place))

    def _are_tall(self, believed: Integers, label: Integers) -> Bools:
        """(K,) clusters of points well above the road that are bodies beyond doubt."""
        marks, config, count = self._points, self.config, int(label.max()) + 1
        support = np.bincount(label, minlength=count)
        founders = np.bincount(label, marks.seed_weight[believed], count)
        together: Bools = (founders >= 2) | ((founders >= 1) & (support >= 3))
        rules = config.single_point
        if rules is None:
            return together
        ratio = marks.sigma_m[believed] / marks.depth_m[believed]
        least_m = np.interp(ratio, rules.depth_ratio, rules.min_height_m, right=np.inf)
        single = (
            (marks.hits[believed] >= frames(config.single_hits_s, self._rate_hz))
            & (marks.height_m[believed] > least_m)
            & (marks.height_m[believed] < rules.max_height_m)
            & (marks.depth_m[believed] < rules.far_m)
            & (marks.seed_weight[believed] == 1.0)
        )
        return together | (np.bincount(label, single, count) > 0)

    def _are_low(self, believed: Integers, label: Integers, shaded: Bools, config: LowObstacleConfig) -> Bools:
        """(K,) clusters of low points that are bodies beyond doubt; it takes one more where any is `shaded` (B,)."""
        marks, count = self._points, int(label.max()) + 1
        wanted = config.least_points + (np.bincount(label, shaded, count) > 0)
        margin = np.bincount(label, np.minimum(marks.margin[believed], config.most_margin), count)
        together: Bools = (np.bincount(label, minlength=count) >= wanted) & (margin > config.least_margin)
        rules = config.single_point
        if rules is None:
            return together
        single = (
            (marks.hits[believed] >= frames(self.config.single_hits_s, self._rate_hz))
            & (marks.margin[believed] > rules.margin)
            & (marks.texture[believed] > rules.texture)
            & ~shaded
        )
        return together | (np.bincount(label, single, count) > 0)

    def _describe(
        self,
        believed: Integers,
        label: Integers,
        confirmed: Bools,
        seen: Seen,
        angle: Floats,
        apart: Bools,
        old: Bools,
    ) -> Obstacles:
        """Face and sides across the road, along which a body stands; those `apart` (K,) parted from no other.

        Across the car's way, when that is at an angle, the far end of a long one would count as its width: `seen` is
        turned by `angle` (K,), the road's direction at each body.
        """
        count = len(confirmed)
        config = self.config
        face, face_sigma = face_of(seen, label, count, config.face_correction.sigmas if config.face_correction else 0.0)
        placed = (face_sigma < config.face_sigma_m) & (face < config.told_m)
        body = self._named(believed, label, confirmed, placed, apart)
        confirmed = confirmed & (body >= 0)
        across = sides(seen, label, face, config)  # where most of it is: behind a corner it slides
        begin = nearest_sure(seen, label, face, config.near_corner) if config.near_corner else face
        face, left, right = turned_back(begin, *across, angle)
        ahead = face - self.camera.forward_m
        parts_of = np.where(confirmed & ~apart, body, -1)
        support = np.bincount(label)
        no_body = np.zeros(count, np.bool_)
        if config.fragment:
            no_body |= parted(ahead, left, right, angle, parts_of, support, config.fragment)
        if config.stale and config.stale.part:
            no_body |= outdated(ahead, old, label, parts_of, support)
        self.parts = np.concatenate([self.parts, self._points.identity[believed[no_body[label]]]])
        marks = self._points
        if config.stale and config.stale.high:
            high = np.bincount(label, marks.low[believed] | (marks.seed_weight[believed] == 1.0), count) == 0
            gone = high & (np.bincount(label, ~old, count) == 0)
            self.gone = np.concatenate([self.gone, marks.identity[believed[gone[label]]]])
        c = confirmed & ~no_body
        return Obstacles(face[c], left[c], right[c], face_sigma[c], np.full(np.count_nonzero(c), np.inf), body[c])

    def _came_near(self, believed: Integers, place_m: Floats) -> Bools:
        """(B,) points at places (B, 2) in the picture, not placed again though the car has come so much nearer.

        What is nearer than `turned.near_m` may not be judged.
        """
        camera, config = self.camera, self.config
        if config.stale is None:
            return np.zeros(len(believed), np.bool_)
        depth = place_m[:, 0] - camera.forward_m
        inside = np.abs(place_m[:, 1]) * camera.fx_px < 0.5 * camera.width_px * depth
        near: Bools = inside & (depth < config.stale.share * self._points.depth_m[believed])
        return near & (depth > (config.turned.near_m if config.turned else config.near_m))

    def _named(self, believed: Integers, label: Integers, confirmed: Bools, placed: Bools, apart: Bools) -> Integers:
        """(K,) identities of bodies: the one that its points had before, a new one if it is well placed, or else -1.

        Those `apart` do not go on under the identity of a body that they were taken for a part of, once well placed.
        Nor does one that has a name of its own take that of a body whose points, most of them elsewhere, joined it, or
        one that is not well placed that of a body of which it is a splinter: its depth was wrong.
        """
        count, unknown = len(confirmed), np.iinfo(np.int64).max
        before = self._points.body[believed]
        known = np.where(before >= 0, before, unknown)
        others = apart[label] & among(known, known[(confirmed & ~apart)[label]])
        own, body, shared = np.full((3, count), unknown)
        np.minimum.at(own, label, np.where(others | ~_mostly_here(known, label, count), unknown, known))
        np.minimum.at(body, label, np.where(others, unknown, known))
        np.minimum.at(shared, label, known)
        body = np.where((own == unknown) & placed, body, own)
        fresh = np.flatnonzero(confirmed & placed & (body == unknown))
        body[fresh] = [self.number() for _ in fresh]
        body = np.where((body == unknown) & apart, shared, body)
        body[body == unknown] = -1
        self._points.body[believed] = np.where(confirmed[label], body[label], before)
        return body


def _mostly_here(name: Integers, label: Integers, count: int) -> Bools:
    """(M,) points that are in that of `count` clusters in which most of the points are that bear their name."""
    _, index = np.unique(name, return_inverse=True)
    points = np.bincount(index * count + label, minlength=(int(index.max()) + 1) * count).reshape(-1, count)
    here: Bools = points.argmax(axis=1)[index] == label
    return here
