"""Bodies that move: followed points that neither the road nor anything standing on it explains.

A standing point has at least the inverse depth of the road behind it, 1 / Z >= 1 / Z_road: it cannot lie below the
road. A body that drives our way at the speed v_b, seen from a car at v, is triangulated as if it stood at the inverse
depth

    w = (1 - v_b / v) / Z,

farther off than it is, and so its lower part below the road; one that runs away (w < 0) behind the camera. w fixes the
time to contact, never the distance. The distance comes from the foot: the lowest points of a body stand on the road.

What is suspected so is then followed as one rigid body that drives along the road (`moving_frame`, `mover`), and each
look speaks for it or against it: the mirror images of what stands, drops on the glass and tracks that slip along a line
also lie below the road, but the road shines through them, they fill no upright outline as wide as a vehicle, and do not
move as one when we move across.
"""

from dataclasses import dataclass, field

import numpy as np

from vpf_sim.perception.landmarks import carriageway_offsets, near_edge_line
from vpf_sim.perception.marks import Integers
from vpf_sim.perception.mover import FilterConfig, Mover, Sight
from vpf_sim.perception.moving_frame import Residuals, against, part
from vpf_sim.perception.triangulation import NoiseModel, Triangulation
from vpf_sim.types import Bools, Camera, Floats, Flow, Obstacles, RoadEdges


@dataclass(frozen=True, slots=True)
class MoverConfig:
    """When points move, how many make a body, and how long it is kept in mind."""

    window_px: int = 11  # of the flow, for the noise of a track
    search_s: float = 0.2  # between searches for new bodies
    look_s: float = 0.05  # between looks at those that are followed
    chi2_margin: float = 20.0  # by which the road must fit worse
    chi2_ratio: float = 0.3  # of a suspect's chi2 as standing to that as road: it may move across
    chi2_limit: float = 9.0
    odds: float = 4.0  # by which a track of a body may fit worse than one that stands
    below_ratio: float = 0.12  # of the road's inverse depth, by which a point must lie below
    least_baseline_m: float = 0.4  # own way since the first sighting
    least_drop: float = 0.025  # tangent below the horizon of points that move
    near_m: float = 2.5  # range of depth in which bodies are found
    far_m: float = 25.0
    most_suspects: int = 3  # that are looked at beside those believed
    least_points: int = 2  # that raise suspicion
    least_members: int = 4  # of a look that speaks for a body
    least_share: float = 0.6  # of the tracks in its outline
    kept_share: float = 0.4  # once it is believed
    least_thickness_m: float = 0.2  # of its points about a line: tracks slip along lines
    car_m: float = 2.0  # a body that is higher is no car's,
    wide_m: float = 2.2  # and so not narrower
    least_height_m: float = 0.4  # from its lowest to its highest point
    front_m: float = 0.8  # of its face, and so of its width
    foot_m: float = 0.4  # its lowest point is not higher
    least_width_m: float = 1.3
    least_mps: float = 2.0  # of a body that is believed
    follow_m: float = 4.0  # nearer than this a body reaches beyond the picture, and is predicted,
    follow_bearing: float = 0.7  # as beyond this tangent
    side_quantile: float = 0.05  # of its points, that make its sides
    link_m: float = 1.1  # half an outline's width
    glass_m: float = 0.3  # of a vehicle, below the camera and up: windows show what is behind
    alike_ratio: float = 0.15
    slowest_share: float = 0.65  # of the closing speed in the own speed,
    equal_share: float = 0.1  # and least
    length_m: float = 4.5  # of a body
    margin_m: float = 0.3  # about it
    tallest_m: float = 3.6
    prior: float = -4.0  # log-odds of what is suspected
    speaks_for: float = 1.2  # change of the log-odds by a look
    speaks_against: float = 1.0
    independent_s: float = 0.1  # between looks that count in full
    believed: float = 1.0  # log-odds
    sure: float = 3.0  # from here on its points are no landmarks
    most: float = 6.0
    fade_per_s: float = 0.6  # of the log-odds while it cannot be looked at
    vague_m: float = 15.0  # standard deviation of the distance, and
    behind_m: float = 25.0  # where it is forgotten
    edge_line_m: float = 0.4  # points whose foot lies so near the edge line inside,
    verge_m: float = 1.8  # and so near outside, found no body
    edge_margin_m: float = 1.0  # inside the carriageway's edges is its middle
    noise: NoiseModel = field(default_factory=NoiseModel)  # of the tracks
    filter: FilterConfig = field(default_factory=FilterConfig)


@dataclass(frozen=True, slots=True)
class Apparent:
    """N followed points as if they stood: inverse depths from the camera, + is ahead."""

    inverse_per_m: Floats  # (N,) w
    sigma_per_m: Floats  # (N,)
    drop: Floats  # (N,) tangent below the horizon
    bearing: Floats  # (N,) tangent, + is right
    own_mps: Floats  # (N,) own mean speed since the first sighting
    ripe: Bools  # (N,) seen for long enough to tell
    still: Bools  # (N,) of these, on the glass, or of a body as fast as we are
    road: Bools  # (N,) of the road
    standing: Floats  # (N,) chi2 of what stands or lies on the road
    moves: Bools  # (N,) below the road beyond doubt


def appear(flow: Flow, points: Triangulation, camera: Camera, rate_hz: float, config: MoverConfig) -> Apparent:
    """The followed points, and which of them no standing body explains."""
    x = (flow.points_px[:, 0] - camera.cx_px) / camera.fx_px
    y = (flow.points_px[:, 1] - camera.cy_px) / camera.fy_px
    drop = np.cos(camera.pitch_rad) * y + np.sin(camera.pitch_rad)
    below = drop / camera.height_m
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse, sigma = points.inverse_per_m, points.inverse_sigma_per_m
        way = np.hypot(*(flow.pose[:2] - flow.first_pose[:, :2]).T)
        own = np.maximum(way * rate_hz / np.maximum(flow.age_frames, 1), 0.1)
        ripe = (way > config.least_baseline_m) & np.isfinite(inverse)
        moves = ripe & ~flow.stuck & (drop > config.least_drop)
        moves &= points.chi2 < np.maximum(config.chi2_limit, config.chi2_ratio * points.chi2_ground)
        moves &= inverse + 3.0 * sigma < (1.0 - config.below_ratio) * below
        moves &= points.chi2_ground - points.chi2 > config.chi2_margin
        road = ripe & (points.chi2_ground < config.chi2_limit)
        standing = np.where(inverse < below, points.chi2_ground, points.chi2)
    return Apparent(inverse, sigma, drop, x, own, ripe, flow.stuck, road, standing, moves)


class MoverTracker:
    """Finds bodies that move, follows them, and keeps them in mind where they are not seen."""

    def __init__(self, camera: Camera, config: MoverConfig, rate_hz: float) -> None:
        self.camera, self.config, self.rate_hz = camera, config, rate_hz
        self.movers: list[Mover] = []
        self._search = max(1, round(config.search_s * rate_hz))
        self._look = max(1, round(config.look_s * rate_hz))
        self._frame = 0
        self._time_s = 0.0
        self._pose: Floats | None = None
        self._next = 1

    def update(self, flow: Flow, points: Triangulation, road: RoadEdges, time_s: float) -> Bools:
        """Follow all bodies to this frame; (N,) points of the flow that belong to one or shine through it."""
        dt_s, self._time_s = time_s - self._time_s, time_s
        own = float(np.hypot(*(flow.pose - self._pose)[:2])) / dt_s if self._pose is not None and dt_s > 0.0 else 0.0
        self._pose = flow.pose
        self._frame += 1
        hidden = np.zeros(len(flow), np.bool_)
        for mover in self.movers:
            ahead = min(max(mover.place(flow.pose)[0], -self.config.behind_m), 1.5 * self.config.far_m)
            direction = flow.pose[2] + road.heading_rad + road.curvature_per_m * ahead
            mover.predict(dt_s, direction, road.curvature_per_m)
        search, look = self._frame % self._search == 1, self._frame % self._look == 0
        if not (search or (look and self.movers)):
            return hidden
        seen = appear(flow, points, self.camera, self.rate_hz, self.config)
        free = seen.moves.copy()
        for mover in self.movers:
            mine, within = self._follow(mover, seen, flow, own) if look else (mover.mine(flow), False)
            free &= ~mine
            if mover.log_odds > self.config.sure:
                hidden |= (mine | within) & seen.ripe
        if self.movers:
            self._merge(flow.pose)
            self._believe()
            self._forget(flow.pose, road)
        if search:
            self._find(seen, free, flow, road)
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

    def _follow(self, mover: Mover, seen: Apparent, flow: Flow, own_mps: float) -> tuple[Bools, Bools]:
        """Bring a body to this frame by its tracks; (N,) points that are of it, and (N,) those seen through it."""
        config, dt_s = self.config, self._look / self.rate_hz
        within = self._outline(mover, seen, flow.pose)
        forward, right = mover.place(flow.pose)
        depth = forward - self.camera.forward_m
        if not (depth > config.follow_m and abs(right) < config.follow_bearing * depth) or not seen.ripe.any():
            mover.log_odds -= config.fade_per_s * dt_s if mover.identity is not None else np.inf
            return mover.mine(flow), within
        follows = abs(own_mps - mover.speed_mps) < config.equal_share * own_mps  # then what is on it stands still
        chosen = np.flatnonzero(within & seen.ripe & (follows | ~seen.still))
        tracks, standing = part(flow, chosen), seen.standing[chosen]
        chi2, behind, faster = mover.fit(self._against(mover, tracks, depth), standing, own_mps, depth)
        chi2 = np.where(chi2 < standing + config.odds, chi2, np.inf)
        face = chi2 < config.chi2_limit
        mover.tracks = flow.identity[chosen[face]]
        good = False
        if np.count_nonzero(face) >= 3:
            mover.grow(faster, int(np.count_nonzero(face)), dt_s)
            foot = self._foot(seen.drop[chosen[face]])
            if foot is not None:
                mover.stand(foot, own_mps, flow.pose, dt_s)
            depth = mover.depth_m(flow.pose)
            front = (
                face & (behind < config.front_m) if np.count_nonzero(face & (behind < config.front_m)) >= 3 else face
            )
            across = seen.bearing[chosen[front]] * depth
            left, right = np.quantile(across, (config.side_quantile, 1.0 - config.side_quantile))
            mover.spread(float(left), float(right), flow.pose, dt_s)
            good = self._speaks_for(mover, seen, chosen, chi2, own_mps, flow.pose)
        gain = config.speaks_for if good else -config.speaks_against
        mover.log_odds = min(mover.log_odds + gain * dt_s / config.independent_s, config.most)
        with np.errstate(invalid="ignore"):
            return mover.mine(flow), within & (seen.inverse_per_m < 1.0 / max(depth - 1.0, 1.0))

    def _outline(self, mover: Mover, seen: Apparent, pose: Floats) -> Bools:
        """(N,) points in the outline of a body."""
        config = self.config
        forward, right = mover.place(pose)
        depth = forward - self.camera.forward_m
        if depth < 1.0:
            return np.zeros(len(seen.drop), np.bool_)
        margin = config.margin_m + 0.02 * depth
        sides = np.array([right - mover.half_m - margin, right + mover.half_m + margin])
        bearings = sides / np.array([[depth], [depth + config.length_m]])
        within = (seen.bearing > bearings.min()) & (seen.bearing < bearings.max())
        within &= seen.drop * depth > self.camera.height_m - config.tallest_m
        inside: Bools = within & (seen.drop * depth < 1.2 * self.camera.height_m)
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

    def _speaks_for(
        self, mover: Mover, seen: Apparent, chosen: Integers, chi2: Floats, own_mps: float, pose: Floats
    ) -> bool:
        """Whether a look shows an upright body as wide as a vehicle, of which nothing shines through."""
        config = self.config
        forward, right = mover.place(pose)
        depth = forward - self.camera.forward_m
        height = self.camera.height_m - seen.drop[chosen] * depth
        across = seen.bearing[chosen] * depth - right
        face = chi2 < config.chi2_limit
        inside = (height > 0.3) & (height < 1.3) & (np.abs(across) < mover.half_m)
        count = int(np.count_nonzero(face & inside))
        beyond_doubt = int(np.count_nonzero(face & (seen.standing[chosen] - chi2 > config.chi2_limit)))
        strange = inside & ~face
        against_it = 0.5 * (np.count_nonzero(strange & seen.road[chosen]) + np.count_nonzero(strange))
        low, high = np.min(height[face]), np.max(height[face])
        upright = count >= config.least_members and low < config.foot_m and high - low > config.least_height_m
        share = 1.0 - mover.speed_mps / max(own_mps, 0.1)
        tall = np.count_nonzero(face & (height > config.car_m)) >= 3 and mover.width_m < config.wide_m
        new = mover.identity is None
        least = config.least_share if new else config.kept_share
        return bool(
            upright
            and count >= least * (count + against_it)
            and mover.width_m > config.least_width_m
            and (not new or (not tall and _thickness(across[face], height[face]) > config.least_thickness_m))
            and (
                not new
                or (
                    beyond_doubt >= 3
                    and mover.speed_mps > config.least_mps
                    and not -0.5 * config.equal_share < share < config.equal_share
                )
            )
        )

    def _merge(self, pose: Floats) -> None:
        """Two parts of one body, side by side in one lane or one before the other, become one: the surer."""
        if len(self.movers) < 2:
            return
        config = self.config
        kept: list[Mover] = []
        for mover in sorted(self.movers, key=lambda mover: mover.place(pose)[0]):
            forward, right = mover.place(pose)
            for other in kept:
                ahead, aside = np.subtract((forward, right), other.place(pose))
                alike = abs(mover.speed_mps - other.speed_mps) < 2.0
                if other.log_odds < min(mover.log_odds, config.believed):
                    continue
                if alike and abs(ahead) < config.length_m + 1.0 and abs(aside) < other.half_m + mover.half_m + 0.2:
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
            left_edge, right_edge = carriageway_offsets(np.array([forward]), road)
            on_road = left_edge[0] - 0.5 < right < right_edge[0] + 0.5 or abs(forward) > config.far_m
            known = -config.behind_m < forward < 1.5 * config.far_m and mover.sigma_m < config.vague_m
            least = 0.0 if mover.identity is not None else config.prior - 1.0
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
        for mine in self._outlines(seen, feet, spare):
            sight = self._suspect(seen, mine)
            if self._is_plausible(sight, road):
                self.movers.append(Mover(sight, self.camera, flow.pose, config.prior, config.filter))

    def _outlines(self, seen: Apparent, feet: Integers, most: int) -> list[Integers]:
        """For the best of the suspected feet, the tracks that move as it does in the outline of a vehicle on it."""
        config = self.config
        ripe = np.flatnonzero(seen.ripe & ~seen.still & (seen.drop > 0.0))
        depth = self.camera.height_m / seen.drop[feet][:, None]
        inside = np.abs(seen.bearing[ripe] - seen.bearing[feet][:, None]) * depth < config.link_m
        inside &= (seen.drop[ripe] < 1.03 * seen.drop[feet][:, None]) & (seen.drop[ripe] * depth > config.glass_m)
        gap = np.abs(seen.inverse_per_m[ripe] - seen.inverse_per_m[feet][:, None])
        doubt = 3.0 * np.hypot(seen.sigma_per_m[ripe], seen.sigma_per_m[feet][:, None])
        alike = inside & (gap < doubt + config.alike_ratio * np.abs(seen.inverse_per_m[feet][:, None]))
        found: list[Integers] = []
        while len(found) < most:
            count = np.count_nonzero(alike, axis=1)
            good = (count >= config.least_members) & (count >= 0.5 * np.count_nonzero(inside, axis=1))
            if not good.any():
                break
            best = int(np.argmax(np.where(good, count, 0)))
            mine = alike[best]
            if float(np.ptp(seen.drop[ripe[mine]])) * float(depth[best, 0]) > config.least_height_m:
                found.append(ripe[mine])
            inside, alike = inside & ~mine, alike & ~mine
        return found

    def _suspect(self, seen: Apparent, mine: Integers) -> Sight:
        """What the tracks in an outline tell of the body."""
        depth = (self.camera.height_m - self.config.filter.foot_height_m) / float(np.sort(seen.drop[mine])[-2:].mean())
        own = float(np.median(seen.own_mps[mine]))
        share = float(np.median(seen.inverse_per_m[mine])) * depth
        across = seen.bearing[mine] * depth
        middle, half = 0.5 * (across.min() + across.max()), max(0.9, 0.5 * float(np.ptp(across)))
        return Sight(
            depth, own * (1.0 - share), 0.5 + 0.2 * own * abs(share), float(middle - half), float(middle + half)
        )

    def _is_plausible(self, sight: Sight, road: RoadEdges) -> bool:
        """It drives, and on the carriageway."""
        config = self.config
        if not config.near_m < sight.depth_m < config.far_m:
            return False
        middle = 0.5 * (sight.left_m + sight.right_m)
        left, right = carriageway_offsets(np.array([self.camera.forward_m + sight.depth_m]), road)
        inside = left[0] + config.edge_margin_m < middle < right[0] - config.edge_margin_m
        return bool(inside and 1.0 < sight.speed_mps < 25.0)


def together(some: Obstacles, others: Obstacles) -> Obstacles:
    """The bodies of both."""
    names = Obstacles.__slots__
    return Obstacles(*(np.concatenate([getattr(some, name), getattr(others, name)]) for name in names))


def _thickness(across_m: Floats, height_m: Floats) -> float:
    """m, root mean square distance of points from the straight line that fits them best: tracks on a line have none."""
    return float(np.sqrt(np.linalg.eigvalsh(np.cov(across_m, height_m, ddof=0))[0]))
