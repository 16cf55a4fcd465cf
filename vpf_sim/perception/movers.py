"""Bodies that move: followed points that neither the road nor anything standing on it explains.

A standing point has at least the inverse depth of the road behind it, 1 / Z >= 1 / Z_road: it cannot lie below the
road. A body that drives our way at the speed v_b, seen from a car at v, is triangulated as if it stood at the inverse
depth

    w = (1 - v_b / v) / Z,

farther off than it is, and so its lower part below the road; one that runs away (w < 0) behind the camera. w fixes the
time to contact, never the distance. The distance comes from the foot: the lowest points of a body stand on the road.
"""

from dataclasses import dataclass, field

import numpy as np

from vpf_sim.perception.landmarks import carriageway_offsets, connected, near_edge_line
from vpf_sim.perception.mover import FilterConfig, Mover, Sight
from vpf_sim.perception.triangulation import Triangulation
from vpf_sim.types import Bools, Camera, Floats, Flow, Obstacles, RoadEdges


@dataclass(frozen=True, slots=True)
class MoverConfig:
    """When points move, how many make a body, and how long it is kept in mind."""

    chi2_limit: float = 9.0  # of a point against its own depth, plus
    chi2_ratio: float = 0.03  # this share of its chi2 against the road: long windows drift
    chi2_margin: float = 20.0  # by which the road must fit worse
    below_ratio: float = 0.12  # of the road's inverse depth, by which a point must lie below
    least_baseline_m: float = 0.4  # own way since the first sighting
    least_drop: float = 0.025  # tangent below the horizon of points that move
    least_drop_m: float = 0.2  # below the camera, of what counts for a body's place
    near_m: float = 2.5  # range of depth in which bodies are found
    far_m: float = 32.0
    least_points: int = 3  # that found a body
    least_height_m: float = 0.5  # up to which a body is seen
    least_width_m: float = 1.15  # a mirror image, twice as far as its foot tells, seems half as wide
    least_mps: float = 1.5
    share_sigma: float = 0.08  # standard deviation of 1 - v_b / v, plus
    share_ratio: float = 0.2  # this share of it
    face_quantile: float = 0.7  # of the apparent inverse depths of a body's points: its face is nearest
    follow_m: float = 3.5  # nearer than this a body reaches beyond the picture, and is predicted,
    follow_bearing: float = 0.8  # as beyond this tangent
    side_quantile: float = 0.08  # of its points, that make its sides
    link_m: float = 1.3  # points of a body are nearer to each other
    length_m: float = 4.5  # of a body
    margin_m: float = 0.3  # about it
    tallest_m: float = 3.6
    hits_s: float = 0.25  # a body is believed after so long
    gap_s: float = 0.3  # one not yet believed may be lost for so long
    lost_s: float = 1.0  # and one believed, where it should be seen
    vague_m: float = 12.0  # standard deviation of the distance, and
    behind_m: float = 25.0  # where it is forgotten
    edge_line_m: float = 0.4  # points whose foot lies so near the edge line inside,
    verge_m: float = 1.8  # and so near outside, found no body
    edge_margin_m: float = 0.3  # inside the carriageway's edges
    filter: FilterConfig = field(default_factory=FilterConfig)


@dataclass(frozen=True, slots=True)
class Apparent:
    """N followed points as if they stood: inverse depths from the camera, + is ahead."""

    inverse_per_m: Floats  # (N,) w
    sigma_per_m: Floats  # (N,)
    drop: Floats  # (N,) tangent below the horizon
    bearing: Floats  # (N,) tangent, + is right
    own_mps: Floats  # (N,) own mean speed since the first sighting
    agrees: Bools  # (N,) some depth explains it: it may belong to a body that keeps its direction
    moves: Bools  # (N,) below the road beyond doubt


def appear(flow: Flow, points: Triangulation, camera: Camera, rate_hz: float, config: MoverConfig) -> Apparent:
    """The followed points, and which of them no standing body explains."""
    x = (flow.points_px[:, 0] - camera.cx_px) / camera.fx_px
    y = (flow.points_px[:, 1] - camera.cy_px) / camera.fy_px
    drop = np.cos(camera.pitch_rad) * y + np.sin(camera.pitch_rad)
    road = drop / camera.height_m
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse, sigma = points.inverse_per_m, points.inverse_sigma_per_m
        way = np.hypot(*(flow.pose[:2] - flow.first_pose[:, :2]).T)
        own = np.maximum(way * rate_hz / np.maximum(flow.age_frames, 1), 0.1)
        agrees = points.chi2 < np.maximum(config.chi2_limit, config.chi2_ratio * points.chi2_ground)
        agrees &= (way > config.least_baseline_m) & np.isfinite(inverse)
        moves = agrees & (drop > config.least_drop)
        moves &= inverse + 3.0 * sigma < (1.0 - config.below_ratio) * road
        moves &= points.chi2_ground - points.chi2 > config.chi2_margin
    return Apparent(inverse, sigma, drop, x, own, agrees, moves)


class MoverTracker:
    """Finds bodies that move, follows them, and keeps them in mind where they are not seen."""

    def __init__(self, camera: Camera, config: MoverConfig, rate_hz: float) -> None:
        self.camera, self.config, self.rate_hz = camera, config, rate_hz
        self.movers: list[Mover] = []
        self._time_s = 0.0
        self._next = 1

    def update(self, flow: Flow, points: Triangulation, road: RoadEdges, time_s: float) -> Bools:
        """Follow all bodies to this frame; (N,) points of the flow that belong to one or shine through it."""
        seen = appear(flow, points, self.camera, self.rate_hz, self.config)
        free = seen.moves.copy()
        hidden = np.zeros(len(flow), np.bool_)
        dt_s, self._time_s = time_s - self._time_s, time_s
        for mover in self.movers:
            within = self._follow(mover, seen, flow, road, dt_s)
            free &= ~within
            if mover.identity is not None:
                hidden |= within
        if self.movers:
            self._merge(flow.pose)
            self._believe()
            self._forget(flow.pose)
        if np.count_nonzero(free) >= self.config.least_points:
            config = self.config
            free &= ~near_edge_line(self.camera, flow.points_px, road, config.edge_line_m, config.verge_m)
            if np.count_nonzero(free) >= self.config.least_points:
                self._found(seen, free, flow, road)
        return hidden

    def obstacles(self, pose: Floats, speed_mps: float) -> Obstacles:
        """The bodies believed, in the axes of the vehicle; their identities are negative."""
        believed = [mover for mover in self.movers if mover.identity is not None]
        place = np.array([mover.place(pose) for mover in believed]).reshape(-1, 2)
        half = np.array([mover.half_m for mover in believed])
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

    def _follow(self, mover: Mover, seen: Apparent, flow: Flow, road: RoadEdges, dt_s: float) -> Bools:
        """Bring a body to this frame; (N,) points in its outline that do not stand before it."""
        ahead = min(max(mover.place(flow.pose)[0], -self.config.behind_m), self.config.far_m)
        mover.predict(dt_s, flow.pose[2] + road.heading_rad + road.curvature_per_m * ahead)
        members, within = self._members(mover, seen, flow.pose)
        forward, right = mover.place(flow.pose)
        depth = forward - self.camera.forward_m
        whole = depth > self.config.follow_m and abs(right) < self.config.follow_bearing * depth
        sight = self._measure(seen, members, depth) if whole else None
        if sight is not None and sight.top_m > self.config.least_height_m:
            mover.update(sight, flow.pose, self._time_s, dt_s)
        elif not seen.agrees.any():  # we stand: nothing can be told of it
            mover.seen_s += dt_s
        return within

    def _members(self, mover: Mover, seen: Apparent, pose: Floats) -> tuple[Bools, Bools]:
        """(N,) points that move as the body does, and (N,) points in its outline that do not stand before it."""
        config = self.config
        forward, right = mover.place(pose)
        depth = forward - self.camera.forward_m
        none = np.zeros(len(seen.drop), np.bool_)
        if depth < 1.0:
            return none, none
        margin = config.margin_m + 0.02 * depth
        sides = np.array([right - mover.half_m - margin, right + mover.half_m + margin])
        bearings = sides / np.array([[depth], [depth + config.length_m]])
        within = (seen.bearing > bearings.min()) & (seen.bearing < bearings.max())
        within &= seen.drop * depth > self.camera.height_m - config.tallest_m
        within &= seen.drop * depth < 1.2 * self.camera.height_m
        chosen = np.flatnonzero(within)
        inverse, sigma = seen.inverse_per_m[chosen], 3.0 * seen.sigma_per_m[chosen]
        speeds = mover.speed_mps + np.array([-1.0, 1.0]) * (0.4 + 2.0 * mover.sigma_mps)
        depths = np.array([0.85 * depth, depth + config.length_m])
        share = 1.0 - mover.speed_mps / seen.own_mps[chosen]
        bounds = (1.0 - speeds[:, None, None] / seen.own_mps[chosen]) / depths[:, None]
        alike = (inverse + sigma > bounds.min(axis=(0, 1))) & (inverse - sigma < bounds.max(axis=(0, 1)))
        place = seen.bearing[chosen] * self._depths(share, inverse, seen.drop[chosen], depth)
        members = none.copy()
        members[chosen] = alike & seen.agrees[chosen] & (place > sides[0]) & (place < sides[1])
        members &= seen.drop * depth > config.least_drop_m  # what is seen above it may be the background
        with np.errstate(invalid="ignore"):
            through = within & (seen.inverse_per_m < 1.0 / max(depth - 1.0, 1.0))
        return members, through

    def _depths(self, share: Floats | float, inverse: Floats, drop: Floats, nearest_m: float) -> Floats:
        """(M,) m of points that move alike: share / w, not before the face, not below the road, not beyond the body."""
        far = nearest_m + self.config.length_m
        road = np.where(drop > 1e-3, self.camera.height_m / np.maximum(drop, 1e-3), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = np.where(share * inverse > 0.0, share / inverse, np.inf)
        depth = np.where(np.abs(share) < 0.1, nearest_m, depth)  # as fast as we are: w tells no depth
        clipped: Floats = np.maximum(np.minimum(depth, np.minimum(road, far)), nearest_m)
        return clipped

    def _measure(self, seen: Apparent, members: Bools, face_m: float | None = None) -> Sight | None:
        """What the points of a body say together; None where too few move."""
        config = self.config
        chosen = np.flatnonzero(members)
        lowest = chosen[seen.moves[chosen]]
        if len(lowest) < 2:
            return None
        low = float(seen.drop[lowest].max())
        depth = self.camera.height_m / low
        face_m = depth if face_m is None else face_m
        face = _face(seen.inverse_per_m[lowest], seen.sigma_per_m[lowest], config.face_quantile)
        own = float(np.median(seen.own_mps[lowest]))
        share = face * face_m
        depths = self._depths(share, seen.inverse_per_m[chosen], seen.drop[chosen], face_m)
        left, right = np.quantile(seen.bearing[chosen] * depths, (config.side_quantile, 1.0 - config.side_quantile))
        noise = float(np.median(seen.sigma_per_m[lowest])) * face_m
        return Sight(
            depth_m=depth,
            speed_mps=own * (1.0 - share),
            sigma_mps=own * (config.share_sigma + config.share_ratio * abs(share) + noise),
            left_m=float(left),
            right_m=float(right),
            top_m=float((self.camera.height_m - depths * seen.drop[chosen]).max()),
        )

    def _merge(self, pose: Floats) -> None:
        """Two parts of one body, side by side in one lane or one before the other, become one: the nearer."""
        if len(self.movers) < 2:
            return
        config = self.config
        kept: list[Mover] = []
        for mover in sorted(self.movers, key=lambda mover: mover.place(pose)[0]):
            forward, right = mover.place(pose)
            for other in kept:
                ahead, aside = np.subtract((forward, right), other.place(pose))
                alike = abs(mover.speed_mps - other.speed_mps) < 1.5
                if alike and ahead < config.length_m + 1.0 and abs(aside) < other.half_m + mover.half_m + 0.2:
                    names = [name for name in (mover.identity, other.identity) if name is not None]
                    other.identity = min(names, default=None)
                    other.hits = max(other.hits, mover.hits)
                    break
            else:
                kept.append(mover)
        self.movers = kept

    def _believe(self) -> None:
        for mover in self.movers:
            if mover.identity is not None or mover.hits < self.config.hits_s * self.rate_hz:
                continue
            fast = mover.speed_mps > self.config.least_mps + mover.sigma_mps
            if fast and mover.width_m > self.config.least_width_m:
                mover.identity, self._next = self._next, self._next + 1

    def _forget(self, pose: Floats) -> None:
        config = self.config

        def kept(mover: Mover) -> bool:
            forward, right = mover.place(pose)
            unseen = self._time_s - mover.seen_s
            if mover.identity is None:
                return unseen < config.gap_s and forward > config.near_m
            depth = forward - self.camera.forward_m
            visible = config.follow_m < depth < 0.8 * config.far_m and abs(right) < config.follow_bearing * depth
            known = -config.behind_m < forward < 2.0 * config.far_m and mover.sigma_m < config.vague_m
            return known and not (visible and unseen > config.lost_s)

        self.movers = [mover for mover in self.movers if kept(mover)]

    def _found(self, seen: Apparent, free: Bools, flow: Flow, road: RoadEdges) -> None:
        """New bodies from points that move and belong to none."""
        config = self.config
        chosen = np.flatnonzero(free)
        depth = self.camera.height_m / seen.drop[chosen]
        nearer = np.minimum(depth[:, None], depth[None])
        aside = np.abs(seen.bearing[chosen][:, None] - seen.bearing[chosen][None]) * nearer
        above = np.abs(seen.drop[chosen][:, None] - seen.drop[chosen][None]) * nearer
        inverse, sigma = seen.inverse_per_m[chosen], seen.sigma_per_m[chosen]
        alike = np.abs(inverse[:, None] - inverse[None]) < 3.0 * np.hypot(sigma[:, None], sigma[None]) + 0.15 / nearer
        label = connected((aside < config.link_m) & (above < config.link_m) & alike)
        for part in range(int(label.max()) + 1):
            members = np.zeros(len(free), np.bool_)
            members[chosen[label == part]] = True
            if np.count_nonzero(members) < config.least_points:
                continue
            sight = self._measure(seen, members)
            if sight is not None and self._is_plausible(sight, road):
                self.movers.append(Mover(sight, self.camera, flow.pose, self._time_s, config.filter))

    def _is_plausible(self, sight: Sight, road: RoadEdges) -> bool:
        """It drives, and on the carriageway."""
        config = self.config
        if not config.near_m < sight.depth_m < config.far_m:
            return False
        middle = 0.5 * (sight.left_m + sight.right_m)
        left, right = carriageway_offsets(np.array([self.camera.forward_m + sight.depth_m]), road)
        inside = left[0] + config.edge_margin_m < middle < right[0] - config.edge_margin_m
        return bool(inside and sight.speed_mps > config.least_mps)


def together(some: Obstacles, others: Obstacles) -> Obstacles:
    """The bodies of both."""
    names = Obstacles.__slots__
    return Obstacles(*(np.concatenate([getattr(some, name), getattr(others, name)]) for name in names))


def _face(inverse: Floats, sigma: Floats, quantile: float) -> float:
    """1/m, the apparent inverse depth of the nearest of points that move alike."""
    weight = 1.0 / (sigma + 0.1 * np.abs(inverse) + 1e-3) ** 2
    sign = 1.0 if float(weight @ inverse) >= 0.0 else -1.0
    order = np.argsort(sign * inverse)
    share = np.cumsum(weight[order])
    return float(inverse[order[np.searchsorted(share, quantile * share[-1])]])
