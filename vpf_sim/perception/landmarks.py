"""Bodies on the road: followed points that stand above it, kept in the world until the car has passed them."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from vpf_sim.geometry import vehicle_from_world, world_from_vehicle
from vpf_sim.perception.triangulation import NoiseModel, Triangulation, triangulate
from vpf_sim.types import Bools, Camera, Floats, Flow, Obstacles, RoadEdges

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class LandmarkConfig:
    """When a point counts as standing above the road, and how many of them make a body."""

    window_px: int = 11  # of the flow, for the noise of a track
    grey_levels: float = 5.0  # noise of a track, see NoiseModel
    floor_px: float = 0.04
    growth_s: float = 0.17
    anisotropy: float = 0.04
    pitch_rad: float = 0.0005
    min_age_s: float = 0.05
    chi2_limit: float = 9.0  # of a point against its own depth
    chi2_margin: float = 20.0  # by which the road must fit worse
    depth_ratio: float = 0.10  # largest sigma_Z / Z
    min_height_m: float = 0.2
    max_height_m: float = 1.8
    near_m: float = 6.5  # range of depth in which points are judged
    far_m: float = 45.0
    hits_s: float = 0.13  # a point is believed after so long,
    hits_share: float = 0.5  # if it stood above the road in this share of the frames since it first did
    single_hits_s: float = 0.2  # and one alone after so long,
    single_depth_ratio: float = 0.035  # at this accuracy
    single_height_m: float = 1.1
    edge_margin_m: float = 0.3  # inside the carriageway's edges
    horizon_px: float = 2.5  # points so near the horizon need horizon_depth_ratio
    horizon_depth_ratio: float = 0.03
    link_right_m: float = 1.0  # points nearer than this belong to one body
    link_forward_m: float = 2.5
    behind_m: float = 11.0  # where a body is forgotten

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")
        if self.min_height_m >= self.max_height_m:
            raise ValueError(f"min_height_m: expected < max_height_m, got {self.min_height_m}")

    @property
    def noise(self) -> NoiseModel:
        return NoiseModel(self.grey_levels, self.floor_px, self.growth_s, self.anisotropy, self.pitch_rad)


@dataclass(slots=True)
class _Marks:
    """Points that stood above the road at least once: M of them, in the order of the track's identity."""

    identity: Integers  # (M,) of the track
    hits: Integers  # (M,) frames in which it stood above the road, less those in which it lay on it
    place_m: Floats  # (M, 2) in the world
    sigma_m: Floats  # (M,) of the depth at the last hit
    depth_m: Floats  # (M,) at the last hit
    height_m: Floats  # (M,)
    body: Integers  # (M,) identity of its body, -1 none yet
    first_s: Floats  # (M,) time of the first hit
    believed: Bools  # (M,)

    def keep(self, chosen: Bools) -> None:
        for column in fields(self):
            setattr(self, column.name, getattr(self, column.name)[chosen])


def carriageway_offsets(forward_m: Floats, road: RoadEdges) -> tuple[Floats, Floats]:
    """Lateral positions (N,) of the left and right edge at `forward_m`, vehicle axes, by a parabola for each edge."""

    def edge(offset_m: float) -> Floats:
        curvature = road.curvature_per_m / (1.0 - road.curvature_per_m * offset_m)
        start = offset_m / np.cos(road.heading_rad)
        along: Floats = forward_m / np.cos(road.heading_rad)
        bend = 0.5 * curvature * along**2 / np.cos(road.heading_rad)
        place: Floats = start + np.tan(road.heading_rad) * forward_m + bend
        return place

    return edge(road.left_m), edge(road.right_m)


class LandmarkTracker:
    """Confirms points over frames, joins them to bodies, and remembers these in the world.

    A body is never forgotten because it can no longer be measured; only because the car has passed it, or because its
    own points turn out to lie on the road.
    """

    def __init__(self, camera: Camera, config: LandmarkConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self.rate_hz = rate_hz
        none = np.empty(0)
        whole = np.empty(0, np.int64)
        self._marks = _Marks(whole, whole, np.empty((0, 2)), none, none, none, whole, none, none > 0.0)
        self._next_body = 0

    def update(self, flow: Flow, road: RoadEdges, speed_mps: float, time_s: float) -> Obstacles:
        """The bodies ahead after this frame, in the axes of the vehicle at `flow.pose`."""
        points = triangulate(
            flow, self.camera, self.config.window_px, flow.age_frames / self.rate_hz, self.config.noise
        )
        self._record(flow, points, self._above(flow, points, road), self._on_road(points), time_s)
        self._forget(flow)
        return self._bodies(flow.pose, speed_mps)

    def _above(self, flow: Flow, points: Triangulation, road: RoadEdges) -> Bools:
        """(N,) points that stand above the carriageway beyond doubt."""
        config = self.config
        depth = points.depth_m
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = points.sigma_m / depth
            horizon = self.camera.cy_px - self.camera.fy_px * np.tan(self.camera.pitch_rad)
            near_horizon = np.abs(flow.points_px[:, 1] - horizon) < config.horizon_px
            above = (depth > config.near_m) & (depth < config.far_m)
            above &= flow.age_frames >= max(2, round(config.min_age_s * self.rate_hz))
            above &= ratio < np.where(near_horizon, config.horizon_depth_ratio, config.depth_ratio)
            above &= (points.chi2 < config.chi2_limit) & (points.chi2_ground - points.chi2 > config.chi2_margin)
            above &= points.height_m > config.min_height_m + 2.0 * points.height_sigma_m
            above &= points.height_m < config.max_height_m + 2.0 * points.height_sigma_m
            left, right = carriageway_offsets(self.camera.forward_m + depth, road)
            above &= (points.right_m > left + config.edge_margin_m) & (points.right_m < right - config.edge_margin_m)
        return above

    def _on_road(self, points: Triangulation) -> Bools:
        """(N,) points that lie on the road beyond doubt: the only evidence that clears a landmark."""
        with np.errstate(invalid="ignore"):
            return (points.chi2_ground < self.config.chi2_limit) & (
                points.height_m + 2.0 * points.height_sigma_m < self.config.min_height_m
            )

    def _record(self, flow: Flow, points: Triangulation, above: Bools, on_road: Bools, time_s: float) -> None:
        marks = self._marks
        slot = np.searchsorted(flow.identity, marks.identity)
        slot = np.minimum(slot, max(0, len(flow) - 1))
        seen = flow.identity[slot] == marks.identity if len(flow) else np.zeros(len(marks.identity), np.bool_)
        hit = seen & above[slot] if len(flow) else seen
        clear = seen & on_road[slot] if len(flow) else seen
        marks.hits = marks.hits + hit - 2 * clear
        frames = (time_s - marks.first_s) * self.rate_hz
        steady = (marks.hits >= self._frames(self.config.hits_s)) & (marks.hits >= self.config.hits_share * frames)
        marks.believed = (marks.believed | steady) & (marks.hits > 0)
        forward = self.camera.forward_m + points.depth_m
        place = world_from_vehicle(np.stack([forward, points.right_m], axis=1), flow.pose)
        chosen = slot[hit]
        marks.place_m[hit] = place[chosen]
        marks.sigma_m[hit], marks.depth_m[hit] = points.sigma_m[chosen], points.depth_m[chosen]
        marks.height_m[hit] = points.height_m[chosen]
        new = above & ~np.isin(flow.identity, marks.identity, assume_unique=True)
        if np.any(new):
            self._marks = _Marks(
                np.concatenate([marks.identity, flow.identity[new]]),
                np.concatenate([marks.hits, np.ones(np.count_nonzero(new), np.int64)]),
                np.concatenate([marks.place_m, place[new]]),
                np.concatenate([marks.sigma_m, points.sigma_m[new]]),
                np.concatenate([marks.depth_m, points.depth_m[new]]),
                np.concatenate([marks.height_m, points.height_m[new]]),
                np.concatenate([marks.body, np.full(np.count_nonzero(new), -1, np.int64)]),
                np.concatenate([marks.first_s, np.full(np.count_nonzero(new), time_s)]),
                np.concatenate([marks.believed, np.zeros(np.count_nonzero(new), np.bool_)]),
            )

    def _forget(self, flow: Flow) -> None:
        marks = self._marks
        if not len(marks.identity):
            return
        followed = np.isin(marks.identity, flow.identity)
        ahead = vehicle_from_world(marks.place_m, flow.pose)[:, 0] > -self.config.behind_m
        marks.keep((marks.believed | followed) & ahead & (marks.hits > 0))

    def _frames(self, time_s: float) -> int:
        return max(2, round(time_s * self.rate_hz))

    def _bodies(self, pose: Floats, speed_mps: float) -> Obstacles:
        marks, config = self._marks, self.config
        believed = np.flatnonzero(marks.believed)
        place = vehicle_from_world(marks.place_m[believed], pose)
        sigma = marks.sigma_m[believed]
        if not len(believed):
            return _none()
        gap = np.abs(place[:, None] - place[None])
        reach = np.maximum(config.link_forward_m, 2.5 * np.hypot(sigma[:, None], sigma[None]))
        linked = (gap[..., 1] < config.link_right_m) & (gap[..., 0] < reach)
        count, parts = connected_components(linked, directed=False)
        label = parts.astype(np.int64)
        single = (
            (marks.hits[believed] >= self._frames(config.single_hits_s))
            & (sigma < config.single_depth_ratio * marks.depth_m[believed])
            & (marks.height_m[believed] < config.single_height_m)
        )
        confirmed = (np.bincount(label, minlength=count) >= 2) | (np.bincount(label, single, count) > 0)
        return self._describe(believed, label, confirmed, place, sigma, speed_mps)

    def _describe(
        self, believed: Integers, label: Integers, confirmed: Bools, place: Floats, sigma: Floats, speed_mps: float
    ) -> Obstacles:
        count = len(confirmed)
        body = np.full(count, np.iinfo(np.int64).max)
        known = self._marks.body[believed]
        np.minimum.at(body, label[known >= 0], known[known >= 0])
        fresh = np.flatnonzero(confirmed & (body == np.iinfo(np.int64).max))
        body[fresh] = self._next_body + np.arange(len(fresh))
        self._next_body += len(fresh)
        self._marks.body[believed] = np.where(confirmed[label], body[label], known)
        left, right = np.full(count, np.inf), np.full(count, -np.inf)
        np.minimum.at(left, label, place[:, 1])
        np.maximum.at(right, label, place[:, 1])
        face = np.full(count, np.inf)
        np.minimum.at(face, label, place[:, 0])
        weight = 1.0 / np.maximum(sigma, 0.02) ** 2
        face_sigma = 1.0 / np.sqrt(np.bincount(label, weight, count))
        closing = max(speed_mps, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            ttc = np.where((face > 0.0) & (closing > 0.0), face / closing, np.inf)
        c = confirmed
        return Obstacles(face[c], left[c], right[c], face_sigma[c], ttc[c], body[c])


def _none() -> Obstacles:
    empty = np.empty(0)
    return Obstacles(empty, empty, empty, empty, empty, np.empty(0, np.int64))
