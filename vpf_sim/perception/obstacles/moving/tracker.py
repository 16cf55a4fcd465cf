"""Bodies that move: followed points that neither the road nor anything standing on it explains.

A standing point has at least the inverse depth of the road behind it, 1 / Z >= 1 / Z_road: it cannot lie below the
road. A body that drives our way at the speed v_b, seen from a car at v, is triangulated as if it stood at the inverse
depth

    w = (1 - v_b / v) / Z,

farther off than it is, and so its lower part below the road; one that runs away (w < 0) behind the camera. w fixes the
time to contact, never the distance. The distance comes from the foot: the lowest points of a body stand on the road.

What is suspected so is then followed as one rigid body that drives along the road (`moving.moving_frame`,
`moving.track`), and each look speaks for it or against it, by the likelihood of its points, one by one
(`moving.evidence`): the mirror images of what stands, drops on the glass and tracks that slip along a line also lie
below the road, but the road shines through them, they are faint, fill no upright outline as wide as a vehicle, and do
not move as one when we move across. What stands behind a body and may share its flow says nothing of it, neither of its
being nor of its shape.
"""

import numpy as np

from vpf_sim.geometry import rotation
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.collision_alarm import Closing
from vpf_sim.perception.obstacles.moving.detection import Apparent, MoverConfig, appear, outlines, suspect
from vpf_sim.perception.obstacles.moving.evidence import Mirror, evidence
from vpf_sim.perception.obstacles.moving.moving_frame import Residuals, against
from vpf_sim.perception.obstacles.moving.track import Mover, Sight
from vpf_sim.perception.obstacles.point_hypotheses import Integers, among
from vpf_sim.perception.quantiles import quantile
from vpf_sim.perception.road.geometry import carriageway_offsets, near_edge_line
from vpf_sim.types import Bools, Camera, Floats, Flow, Obstacles, RoadEdges


class MoverTracker:
    """Finds bodies that move, follows them, and keeps them in mind where they are not seen."""

    def __init__(self, camera: Camera, config: MoverConfig, rate_hz: float) -> None:
        self.camera, self.config, self.rate_hz = camera, config, rate_hz
        self.movers: list[Mover] = []
        self._look = max(1, round(config.look_s * rate_hz))
        self._search = self._look * max(1, round(config.search_s / config.look_s))
        self._closing = Closing(camera, config.closing, self._look / rate_hz)
        self._mirror = Mirror(config.evidence, self._look / rate_hz)
        self._frame = -1
        self._time_s = 0.0
        self._hidden = np.empty(0, np.int64)  # identities of tracks
        self._next = 1

    @property
    def looks(self) -> bool:
        """Whether the next frame is looked at; in the others bodies are only predicted."""
        return (self._frame + 1) % self._look == 0

    def update(
        self, flow: Flow, points: Triangulation | None, road: RoadEdges, speed_mps: float, time_s: float
    ) -> Bools:
        """Follow all bodies to this frame; (N,) points of the flow that belong to one or shine through it.

        `points` are the flow's, as if all of them stood; where the frame is not looked at they may be left out.
        """
        dt_s, self._time_s = time_s - self._time_s, time_s
        look = self.looks
        self._frame += 1
        for mover in self.movers:
            ahead = min(max(mover.place(flow.pose)[0], -self.config.behind_m), 1.5 * self.config.far_m)
            direction = flow.pose[2] + road.heading_rad + road.curvature_per_m * ahead
            mover.predict(dt_s, direction, road.curvature_per_m)
        if look and points is not None:
            if self.movers or self._searches:
                self._look_at(flow, points, road, speed_mps)
            self._closing.look(flow, points, road, speed_mps, ~among(flow.identity, self._hidden))
        return among(flow.identity, self._hidden)

    @property
    def _searches(self) -> bool:
        return self._frame % self._search == 0

    def _look_at(self, flow: Flow, points: Triangulation, road: RoadEdges, speed_mps: float) -> None:
        seen = appear(flow, points, self.camera, self.rate_hz, self.config)
        free = seen.moves.copy()
        hidden = np.zeros(len(flow), np.bool_)
        taken = np.zeros(len(flow), np.bool_)
        self._reflect(seen, flow.pose)
        for mover in sorted(self.movers, key=lambda mover: mover.place(flow.pose)[0]):
            mine, within = self._follow(mover, seen, flow, road, speed_mps, ~taken)
            free &= ~mine
            if mover.identity is not None:
                free &= ~within  # two bodies do not stand in one place
            if mover.identity is not None and mover.is_seen:  # nor is the farther seen through the nearer
                taken |= mine | self._outline(mover, seen, flow.pose, 0.0)
            if mover.log_odds > self.config.sure:
                hidden |= (mine | within) & seen.ripe
        self._hidden = flow.identity[hidden]
        self._merge(flow.pose)
        self._believe()
        self._forget(flow.pose, road)
        if self._searches:
            self._find(seen, free, flow, road)

    def _reflect(self, seen: Apparent, pose: Floats) -> None:
        """Look at how far the road mirrors, outside of all that moves."""
        low = seen.ripe & ~seen.still & (seen.drop > self.config.least_drop)
        for mover in self.movers:
            low &= ~self._outline(mover, seen, pose, self.config.margin_m)
        self._mirror.update(int(np.count_nonzero(low & seen.moves)), int(np.count_nonzero(low)))

    @property
    def reports(self) -> bool:
        """Whether there is anything to tell of."""
        return self._closing.alarms or any(mover.identity is not None for mover in self.movers)

    def obstacles(self, pose: Floats, speed_mps: float, standing: Obstacles) -> Obstacles:
        """All bodies in the axes of the vehicle: the `standing`, the moving, whose identities are negative, and what is
        met soon and is none of these."""
        known = standing.together_with(self.moving(pose, speed_mps))
        return known.together_with(self._closing.obstacles(pose, speed_mps, known))

    def moving(self, pose: Floats, speed_mps: float) -> Obstacles:
        """Those believed to move, in the axes of the vehicle; their identities are negative."""
        believed = [mover for mover in self.movers if mover.identity is not None]
        place = np.array([mover.place(pose) for mover in believed]).reshape(-1, 2)
        half = np.array([mover.reach_m for mover in believed])
        speed = np.array([mover.speed_mps for mover in believed])
        forward, closing = place[:, 0], speed_mps - speed
        with np.errstate(divide="ignore", invalid="ignore"):
            ttc = np.where((forward > 0.0) & (closing > 0.0), forward / closing, np.inf)
        return Obstacles(
            forward_m=forward,
            left_m=place[:, 1] - half,
            right_m=place[:, 1] + half,
            sigma_m=np.array([mover.sigma_m for mover in believed]),
            ttc_s=ttc,
            identity=-np.array([mover.identity for mover in believed], np.int64),
            speed_mps=speed,
        )

    def _follow(
        self, mover: Mover, seen: Apparent, flow: Flow, road: RoadEdges, own_mps: float, free: Bools
    ) -> tuple[Bools, Bools]:
        """Bring a body to this frame by its tracks; (N,) points that are of it, and (N,) those seen through it.

        Its tracks are among those that are `free` (N,): of no nearer body.
        """
        config, dt_s = self.config, self._look / self.rate_hz
        within = self._outline(mover, seen, flow.pose, config.margin_m)
        forward, right = mover.place(flow.pose)
        depth = forward - self.camera.forward_m
        if not (depth > config.follow_m and abs(right) < config.follow_bearing * depth) or not seen.ripe.any():
            self._fade(mover, dt_s)
            return mover.mine(flow), within
        follows = abs(own_mps - mover.speed_mps) < config.equal_share * own_mps  # then what is on it stands still
        about = self._outline(mover, seen, flow.pose, config.margin_m + config.about_m)
        chosen = np.flatnonzero(about & free & seen.ripe & (follows | ~seen.still))
        image = self._image(seen, chosen[within[chosen]], depth)
        chosen = chosen[seen.contrast[chosen] > image]
        tracks, standing, inner = flow.chosen(chosen), seen.standing[chosen], within[chosen]
        fitted, behind, faster = mover.fit(self._against(mover, tracks, depth), standing, own_mps, depth, inner)
        chi2 = np.where(inner & (fitted < standing + config.odds), fitted, np.inf)
        face = chi2 < config.chi2_limit
        mover.tracks = flow.identity[chosen[face]]
        gain = -config.speaks_against
        if np.count_nonzero(face) >= 3:
            mover.grow(faster, int(np.count_nonzero(face)), dt_s)
            sure = face & (standing > chi2 + config.chi2_limit)  # what else is in the outline may shine through
            shape = sure if np.count_nonzero(sure) >= 3 else face
            foot = self._foot(seen.drop[chosen[shape]])
            if foot is not None:
                mover.stand(foot, own_mps, flow.pose, dt_s)
            depth = mover.depth_m(flow.pose)
            front = shape & (behind < config.front_m)
            front = front if np.count_nonzero(front) >= 3 else shape
            self._spread(mover, seen, chosen, front, fitted, flow.pose)
            inside = self._upright(mover, seen, chosen, face, own_mps, flow.pose)
            if inside is not None:
                faint = self._faint(mover, image, own_mps, flow.pose, road)
                gain = evidence(inside, chi2, standing, seen.contrast[chosen], faint, config.evidence)
        self._weigh(mover, gain, dt_s)
        with np.errstate(invalid="ignore"):
            return mover.mine(flow), within & (seen.inverse_per_m < 1.0 / max(depth - 1.0, 1.0))

    def _weigh(self, mover: Mover, gain: float, dt_s: float) -> None:
        """One look spoke for a body by so much."""
        config = self.config
        if mover.identity is not None:
            gain = max(gain, -config.doubts)
        mover.log_odds = min(mover.log_odds + gain * dt_s / config.independent_s, config.most)
        if mover.log_odds > config.sure:
            mover.credit = config.sure  # a body that was sure is not doubted for what the picture's edge leaves of it

    def _fade(self, mover: Mover, dt_s: float) -> None:
        """A body cannot be looked at: it is doubted more and more, and what is only suspected is forgotten."""
        mover.log_odds = max(mover.log_odds, mover.credit) - self.config.fade_per_s * dt_s
        mover.credit = min(mover.credit, mover.log_odds)
        if mover.identity is None:
            mover.log_odds = -np.inf

    def _image(self, seen: Apparent, within: Integers, depth_m: float) -> float:
        """The contrast below which points are of the mirror image of a body that has these in its outline."""
        if depth_m < self.config.steep_m:
            return -np.inf
        height = self.camera.height_m - seen.drop[within] * depth_m
        evidence = self.config.evidence
        upper = within[(height > evidence.image_above_m) & (height < evidence.high_m)]
        return evidence.image(self._mirror.degree, seen.contrast[upper])

    def _faint(self, mover: Mover, image: float, own_mps: float, pose: Floats, road: RoadEdges) -> float:
        """The contrast below which points speak against a body: that of its own `image`, or of asphalt, if what it
        would be the image of stood on the road, where hardly anything does."""
        config = self.config
        forward, right = mover.place(pose)
        depth = forward - self.camera.forward_m
        share = mover.closing_share(own_mps)  # and so of its depth in that of what stands and would move as it does
        is_known = depth > config.steep_m and share * config.mirrored_m > depth
        if is_known and self._is_on_carriageway(depth / share, right / share, road):
            return max(image, config.evidence.faint(0.0, depth))
        return config.evidence.faint(self._mirror.degree, depth)

    def _spread(self, mover: Mover, seen: Apparent, chosen: Integers, front: Bools, chi2: Floats, pose: Floats) -> None:
        """Look at a body's sides by the chosen points, of which those in `front` (M,) make its face.

        What lies on the road tells nothing of them: paint is long, and tracks slip along it.
        """
        config, depth = self.config, mover.depth_m(pose)
        bearing, height = seen.bearing[chosen], self.camera.height_m - seen.drop[chosen] * depth
        face = bearing[front]
        left, right = quantile(face, config.side_quantile), quantile(face, 1.0 - config.side_quantile)
        upright = (height > config.evidence.low_m) & (height < config.evidence.high_m)
        odds = np.minimum(seen.standing[chosen], config.chi2_limit) - np.minimum(chi2, config.chi2_limit)
        mover.spread((right - left) * depth, bearing[upright], 0.5 * odds[upright], pose, self._look / self.rate_hz)

    def _outline(self, mover: Mover, seen: Apparent, pose: Floats, margin_m: float) -> Bools:
        """(N,) points in the outline of a body, or so near beside it."""
        config = self.config
        forward, right = mover.place(pose)
        depth = forward - self.camera.forward_m
        near, far = max(depth, config.nearest_m), depth + config.length_m
        margin = margin_m + 0.02 * near
        left, right = right - mover.half_m - margin, right + mover.half_m + margin
        is_in_us = depth < near and left < 0.0 < right  # it is not where it is believed to be, and would hide all
        if far < near or is_in_us:
            return np.zeros(len(seen.drop), np.bool_)
        inside: Bools = (seen.bearing > min(left / near, left / far)) & (seen.bearing < max(right / near, right / far))
        below = seen.drop * near
        inside &= below > self.camera.height_m - config.tallest_m
        inside &= below < 1.2 * self.camera.height_m
        return inside

    def _against(self, mover: Mover, tracks: Flow, depth_m: float) -> Residuals:
        behind = depth_m + self.config.filter.face_m
        depths = np.full(len(tracks), behind)
        return against(
            tracks, self.camera, mover.course, depths, self.rate_hz, self.config.window_px, self.config.noise
        )

    def _foot(self, drop: Floats) -> float | None:
        """m, the depth of the lowest point but one, taken to be just above the road: the lowest may be a shadow's."""
        low = float(np.sort(drop)[-2])
        height = self.camera.height_m - self.config.filter.foot_height_m
        return height / low if low > self.config.least_drop else None

    def _upright(
        self, mover: Mover, seen: Apparent, chosen: Integers, face: Bools, own_mps: float, pose: Floats
    ) -> Bools | None:
        """(M,) of the chosen points, of which those in `face` (M,) are its, that speak in a look at a body; None where
        its face is nothing upright that is as wide as a vehicle, and drives."""
        config = self.config
        forward, right = mover.place(pose)
        depth = forward - self.camera.forward_m
        height = self.camera.height_m - seen.drop[chosen] * depth
        across = seen.bearing[chosen] * depth - right
        inside = (height > config.evidence.low_m) & (height < config.evidence.high_m)
        inside &= np.abs(across) < mover.half_m + 0.1
        low, high = np.min(height[face]), np.max(height[face])
        upright = np.count_nonzero(face & inside) >= config.least_members and low < config.foot_m
        upright &= high - low > config.least_height_m and mover.width_m > config.least_width_m
        if not upright:
            return None
        if mover.identity is None:
            share = mover.closing_share(own_mps)
            as_fast = -0.5 * config.equal_share < share < config.equal_share  # like the mirror image of what is far off
            thick = _thickness(across[face], height[face]) > config.least_thickness_m
            if as_fast or not thick or mover.speed_mps < config.least_mps:
                return None
        return inside

    def _merge(self, pose: Floats) -> None:
        """Two parts of one body, side by side in one lane or one before the other, become one: the surer."""
        if len(self.movers) < 2:
            return
        config = self.config
        kept: list[Mover] = []
        for mover in sorted(self.movers, key=lambda mover: (-mover.log_odds, mover.place(pose)[0])):
            forward, right = mover.place(pose)
            for other in kept:
                apart = np.subtract((forward, right), other.place(pose))
                ahead, aside = rotation(pose[2] - other.course.direction_rad) @ apart  # along its course and across
                alike = abs(mover.speed_mps - other.speed_mps) < 2.0
                in_sight = other.depth_m(pose) > config.follow_m
                near = other.half_m + mover.half_m + 0.2 if in_sight else config.same_m  # a prediction may be off
                if alike and abs(ahead) < config.length_m + in_sight and abs(aside) < near:
                    names = [name for name in (mover.identity, other.identity) if name is not None]
                    other.identity = min(names, default=None)
                    break
            else:
                kept.append(mover)
        self.movers = kept

    def _believe(self) -> None:
        for mover in self.movers:
            if mover.identity is None and mover.log_odds > self.config.believed:
                mover.identity, self._next = self._next, self._next + 1

    def _forget(self, pose: Floats, road: RoadEdges) -> None:
        config = self.config

        def kept(mover: Mover) -> bool:
            forward, right = mover.place(pose)
            on_road = abs(forward) > config.far_m or _is_on_road(forward, right, road, -0.5)
            known = -config.behind_m < forward < 1.5 * config.far_m and mover.sigma_m < config.vague_m
            least = 0.0 if mover.identity is not None else config.dropped
            return bool(known and on_road and mover.log_odds > least)

        self.movers = [mover for mover in self.movers if kept(mover)]

    def _find(self, seen: Apparent, free: Bools, flow: Flow, road: RoadEdges) -> None:
        """New suspects from points that move and belong to none: the best outlines about one of them."""
        config = self.config
        spare = config.most_suspects - sum(mover.identity is None for mover in self.movers)
        with np.errstate(divide="ignore"):
            free &= self.camera.height_m < config.far_m * seen.drop
        if spare <= 0 or np.count_nonzero(free) < config.least_points:
            return
        free &= ~near_edge_line(self.camera, flow.points_px, road, config.edge_line_m, config.verge_m)
        feet = np.flatnonzero(free)
        share = seen.inverse_per_m[feet] * self.camera.height_m / np.maximum(seen.drop[feet], 1e-3)
        feet = feet[
            (share < config.slowest_share) & ((share > config.equal_share) | (share < -0.5 * config.equal_share))
        ]
        for mine in outlines(seen, feet, spare, self.camera, config):
            lowest_m = self.camera.height_m / float(np.max(seen.drop[mine]))
            members = mine[seen.contrast[mine] > self._image(seen, mine, lowest_m)]
            if len(members) < config.least_members:
                continue
            sight = suspect(seen, members, self.camera, config)
            if self._is_plausible(sight, road):
                self.movers.append(Mover(sight, self.camera, flow.pose, config.prior, config.filter))

    def _is_plausible(self, sight: Sight, road: RoadEdges) -> bool:
        """It drives, and on the carriageway."""
        config = self.config
        if not config.near_m < sight.depth_m < config.far_m:
            return False
        return self._is_on_carriageway(sight.depth_m, sight.middle_m, road) and 1.0 < sight.speed_mps < 25.0

    def _is_on_carriageway(self, depth_m: float, right_m: float, road: RoadEdges) -> bool:
        """Whether the middle of a body may be so far from the camera: its sides within the edges."""
        return _is_on_road(self.camera.forward_m + depth_m, right_m, road, self.config.edge_margin_m)


def _is_on_road(forward_m: float, right_m: float, road: RoadEdges, inside_m: float) -> bool:
    """Whether a place, vehicle axes, is at least so far inside the edges of the carriageway."""
    left, right = carriageway_offsets(np.array([forward_m]), road)
    return bool(left[0] + inside_m < right_m < right[0] - inside_m)


def _thickness(across_m: Floats, height_m: Floats) -> float:
    """m, root mean square distance of points from the straight line that fits them best: tracks on a line have none."""
    return float(np.sqrt(np.linalg.eigvalsh(np.cov(across_m, height_m, ddof=0))[0]))
