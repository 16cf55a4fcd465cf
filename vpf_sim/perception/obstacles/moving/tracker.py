"""Tracker of moving vehicles, from points that neither the road nor a static obstacle explains.

A static point has at least the inverse depth of the road behind it, 1 / Z >= 1 / Z_road: it cannot lie below the road.
A vehicle that drives our way at v_b, seen from a car at v, is triangulated as if it stood at the inverse depth

    w = (1 - v_b / v) / Z,

too far away, so that its lower part lies below the road; a faster one (w < 0) behind the camera. w fixes the time to
contact, never the range. The range comes from the foot: the lowest points of a vehicle stand on the road.

A tentative track is a rigid body that drives along the road (`moving.moving_frame`, `moving.track`). The likelihood of
its points confirms or rejects it (`moving.evidence`): mirror images, drops on the windscreen and point tracks that slip
along a line also lie below the road. But they are faint, the road shines through them, and they fill no upright outline
as wide as a vehicle.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.moving.detection import MeasuredPoints, candidates, detect, measure
from vpf_sim.perception.obstacles.moving.evidence import evidence
from vpf_sim.perception.obstacles.moving.merging import merged
from vpf_sim.perception.obstacles.moving.mirror import MirrorImages
from vpf_sim.perception.obstacles.moving.moving_frame import against
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import MovingObstacleConfig
from vpf_sim.perception.obstacles.moving.place import in_outline
from vpf_sim.perception.obstacles.moving.track import MovingTrack
from vpf_sim.perception.obstacles.point_hypotheses import among
from vpf_sim.perception.quantiles import quantile
from vpf_sim.perception.schedule import Schedule
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers, Obstacles, RoadEdges

OVERLAP_M = 0.1  # of a point beside the silhouette that still speaks for it


@dataclass(frozen=True, slots=True)
class _Frame:
    """One observed frame."""

    seen: MeasuredPoints
    flow: Flow
    road: RoadEdges
    own_mps: float


class MovingObstacleTracker:
    """Detects moving vehicles, tracks them, and predicts those that are not observed."""

    def __init__(
        self, camera: Camera, config: MovingObstacleConfig, rate_hz: float, window_px: int, noise: NoiseModel
    ) -> None:
        self.camera, self.config, self.rate_hz = camera, config, rate_hz
        self._window_px, self._noise = window_px, noise  # of the point tracks
        self.tracks: list[MovingTrack] = []
        self._observation = Schedule(config.look_s, rate_hz)
        self._search = Schedule(config.search_s, self._observation.rate_hz)  # among the observations
        look_s = self._look_s = 1.0 / self._observation.rate_hz
        self.mirror_images = MirrorImages(camera, config, look_s)
        self._time_s = 0.0
        self._masked = np.empty(0, np.int64)  # identities of points
        self._next = 1

    def update(self, flow: Flow, points: Triangulation, road: RoadEdges, speed_mps: float, time_s: float) -> Bools:
        """Bring all tracks to this frame; (N,) points of the flow that no static obstacle may use.

        `points` are the flow's, triangulated as if they stood.
        """
        dt_s, self._time_s = time_s - self._time_s, time_s
        observes = self._observation.step()
        searches = observes and self._search.step()
        for track in self.tracks:
            ahead = min(max(track.place(flow.pose)[0], -self.config.far_m), 1.5 * self.config.far_m)
            direction = flow.pose[2] + road.heading_rad + road.curvature_per_m * ahead
            track.predict(dt_s, direction, road.curvature_per_m)
        if observes and (self.tracks or searches):
            self._observe(flow, points, road, speed_mps, searches)
        return among(flow.identity, self._masked)

    def moving(self, pose: Floats) -> Obstacles:
        """The confirmed tracks, in the axes of the vehicle; their identities are negative."""
        confirmed = [track for track in self.tracks if track.identity is not None]
        place = np.array([track.place(pose) for track in confirmed]).reshape(-1, 2)
        half = np.array([track.half_m for track in confirmed])
        return Obstacles(
            forward_m=place[:, 0],
            left_m=place[:, 1] - half,
            right_m=place[:, 1] + half,
            sigma_m=np.array([track.sigma_m for track in confirmed]),
            ttc_s=np.full(len(confirmed), np.inf),  # the scene, where there is one, works it out
            identity=-np.array([track.identity for track in confirmed], np.int64),
            speed_mps=np.array([track.speed_mps for track in confirmed]),
        )

    def _observe(self, flow: Flow, points: Triangulation, road: RoadEdges, speed_mps: float, searches: bool) -> None:
        config, pose = self.config, flow.pose
        seen = measure(flow, points, self.camera, self.rate_hz, config)
        frame = _Frame(seen, flow, road, speed_mps)
        free = seen.moves.copy()
        masked, taken = np.zeros(len(flow), np.bool_), np.zeros(len(flow), np.bool_)
        self._measure_reflectivity(seen, pose)
        for track in sorted(self.tracks, key=lambda track: track.place(pose)[0]):
            mine, within = self._follow(track, frame, ~taken)
            free &= ~mine
            if track.identity is not None:
                free &= ~within  # two vehicles do not stand in one place
            if track.identity is not None and track.is_observed:  # nor is the farther seen through the nearer
                taken |= mine | self._outline(track, seen, pose, 0.0)
            if track.log_odds > config.mask:
                masked |= (mine | within) & seen.ripe
        self._masked = flow.identity[masked]
        self.tracks = merged(self.tracks, pose, config)
        self._confirm()
        self._prune(pose)
        if searches:
            self._find(frame, free)

    def _measure_reflectivity(self, seen: MeasuredPoints, pose: Floats) -> None:
        low = seen.ripe & ~seen.still & (seen.drop > self.config.least_drop)
        for track in self.tracks:
            low &= ~self._outline(track, seen, pose, self.config.margin_m)
        count = int(np.count_nonzero(low))
        self.mirror_images.reflectivity.update(int(np.count_nonzero(low & seen.moves)), count)

    def _outline(self, track: MovingTrack, seen: MeasuredPoints, pose: Floats, margin_m: float) -> Bools:
        return in_outline(track, seen, pose, margin_m, self.camera, self.config)

    def _follow(self, track: MovingTrack, frame: _Frame, free: Bools) -> tuple[Bools, Bools]:
        """Bring a track to this frame by those of its points that are `free` (N,): of no nearer track.

        Returns (N,) its points, and (N,) points of the background that are seen through its outline.
        """
        config, seen, flow, own_mps = self.config, frame.seen, frame.flow, frame.own_mps
        within = self._outline(track, seen, flow.pose, config.margin_m)
        forward, right = track.place(flow.pose)
        depth = forward - self.camera.forward_m
        if not (depth > config.follow_m and abs(right) < config.follow_bearing * depth) or not seen.ripe.any():
            self._decay(track)
            return track.members(flow), within
        as_fast = abs(own_mps - track.speed_mps) < config.as_fast_share * own_mps
        about = self._outline(track, seen, flow.pose, config.margin_m + config.about_m)
        chosen = np.flatnonzero(about & free & seen.ripe & (as_fast | ~seen.still))
        image = self.mirror_images.own_image(seen, chosen[within[chosen]], depth)
        chosen = chosen[seen.contrast[chosen] > image]
        gain, depth = self._update_track(track, frame, chosen, within[chosen], image)
        track.log_odds = min(track.log_odds + gain * self._look_s / config.independent_s, config.most)
        with np.errstate(invalid="ignore"):
            behind = seen.inverse_per_m < 1.0 / max(depth - 1.0, 1.0)
        return track.members(flow), within & behind

    def _update_track(
        self, track: MovingTrack, frame: _Frame, chosen: Integers, inner: Bools, image: float
    ) -> tuple[float, float]:
        """Update a track by its `chosen` (M,) points, `inner` (M,) of them in its outline; log-odds and its depth."""
        config, dt_s, pose = self.config, self._look_s, frame.flow.pose
        seen, own_mps, depth = frame.seen, frame.own_mps, track.depth_m(frame.flow.pose)
        tracks, standing = frame.flow.select(chosen), seen.standing[chosen]
        depths = np.full(len(tracks), depth + config.filter.face_m)
        residuals = against(tracks, self.camera, track.course, depths, self.rate_hz, self._window_px, self._noise)
        fitted, behind, faster = track.fit(residuals, standing, own_mps, depth, inner)
        chi2, limit = np.where(inner & (fitted < standing + config.odds), fitted, np.inf), config.filter.chi2_limit
        face = chi2 < limit
        track.tracks = frame.flow.identity[chosen[face]]
        if np.count_nonzero(face) < 3:
            return config.evidence.least, depth
        track.update_speed(faster, int(np.count_nonzero(face)), dt_s)
        sure = face & (standing > chi2 + limit)  # background may shine through the outline
        shape = sure if np.count_nonzero(sure) >= 3 else face
        foot = self._foot(seen.drop[chosen[shape]])
        if foot is not None:
            track.update_range(foot, own_mps, pose, dt_s)
        depth = track.depth_m(pose)
        front = shape & (behind < config.filter.face_sigma_m)
        front = front if np.count_nonzero(front) >= 3 else shape
        self._update_extent(track, seen, chosen, front, fitted, pose)
        inside = self._upright(track, seen, chosen, face, pose)
        if inside is None:
            return config.evidence.least, depth
        faint = self.mirror_images.faint(track, image, own_mps, pose, frame.road)
        return evidence(inside, chi2, standing, seen.contrast[chosen], faint, config.evidence), depth

    def _decay(self, track: MovingTrack) -> None:
        """Lower the confidence of a track that cannot be observed."""
        track.log_odds -= self.config.decay_per_s * self._look_s
        if track.identity is None:
            track.log_odds = -np.inf

    def _update_extent(
        self, track: MovingTrack, seen: MeasuredPoints, chosen: Integers, front: Bools, chi2: Floats, pose: Floats
    ) -> None:
        """Update a track's sides by the chosen points (M,), where those in `front` (M,) make its face.

        Points on the road do not count: paint is long, and point tracks slip along it.
        """
        config, depth = self.config, track.depth_m(pose)
        bearing, height = seen.bearing[chosen], self.camera.height_m - seen.drop[chosen] * depth
        left, right = (quantile(bearing[front], at) for at in (config.side_quantile, 1.0 - config.side_quantile))
        upright = (height > config.evidence.low_m) & (height < config.evidence.high_m)
        limit = config.filter.chi2_limit
        odds = np.minimum(seen.standing[chosen], limit) - np.minimum(chi2, limit)
        track.update_extent((left, right), bearing[upright], 0.5 * odds[upright], pose, self._look_s)

    def _foot(self, drop: Floats) -> float | None:
        """m, the depth of the lowest point but one, taken to be just above the road: the lowest may be a shadow's."""
        low = float(np.sort(drop)[-2])
        height = self.camera.height_m - self.config.filter.foot_height_m
        return height / low if low > self.config.least_drop else None

    def _upright(
        self, track: MovingTrack, seen: MeasuredPoints, chosen: Integers, face: Bools, pose: Floats
    ) -> Bools | None:
        """(M,) chosen points that count as evidence, by those in `face` (M,); None: the face is no vehicle's."""
        config = self.config
        forward, right = track.place(pose)
        depth = forward - self.camera.forward_m
        height = self.camera.height_m - seen.drop[chosen] * depth
        across = seen.bearing[chosen] * depth - right
        inside = (height > config.evidence.low_m) & (height < config.evidence.high_m)
        inside &= np.abs(across) < track.half_m + OVERLAP_M
        is_vehicle = bool(np.count_nonzero(face & inside) >= config.least_members)
        low, high = np.min(height[face]), np.max(height[face])
        is_vehicle &= bool(low < config.shape.foot_m and high - low > config.shape.least_height_m)
        is_vehicle &= track.width_m > config.shape.least_width_m
        return inside if is_vehicle else None

    def _confirm(self) -> None:
        for track in self.tracks:
            if track.identity is None and track.log_odds > self.config.confirmed:
                track.identity, self._next = self._next, self._next + 1

    def _prune(self, pose: Floats) -> None:
        config = self.config

        def kept(track: MovingTrack) -> bool:
            forward, _ = track.place(pose)
            known = -config.far_m < forward < 1.5 * config.far_m and track.sigma_m < config.vague_m
            least = 0.0 if track.identity is not None else -config.most
            return bool(known and track.log_odds > least)

        self.tracks = [track for track in self.tracks if kept(track)]

    def _find(self, frame: _Frame, free: Bools) -> None:
        """Begin tentative tracks with the best candidates among the moving points `free` (N,): of no track."""
        config, seen = self.config, frame.seen
        spare = config.most_tentative - sum(track.identity is None for track in self.tracks)
        with np.errstate(divide="ignore"):
            free &= self.camera.height_m < config.far_m * seen.drop
        if spare <= 0 or np.count_nonzero(free) < config.least_points:
            return
        feet = np.flatnonzero(free)
        share = seen.inverse_per_m[feet] * self.camera.height_m / np.maximum(seen.drop[feet], 1e-3)
        for mine in candidates(seen, feet[share < config.slowest_share], spare, self.camera, config):
            lowest_m = self.camera.height_m / float(np.max(seen.drop[mine]))
            members = mine[seen.contrast[mine] > self.mirror_images.own_image(seen, mine, lowest_m)]
            if len(members) < config.least_members:
                continue
            found = detect(seen, members, self.camera, config)
            in_range = config.near_m < found.depth_m < config.far_m
            if in_range and config.slow_mps < found.speed_mps < config.fast_mps:
                self.tracks.append(MovingTrack(found, self.camera, frame.flow.pose, config.prior, config.filter))
