"""Tracks that lie below the road, which nothing that stands does: what they are measured by, and who is suspected."""

from dataclasses import dataclass, field

import numpy as np

from vpf_sim.perception.egomotion.config import NoiseModel
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.collision_alarm import CollisionAlarmConfig
from vpf_sim.perception.obstacles.moving.evidence import EvidenceConfig
from vpf_sim.perception.obstacles.moving.track import FilterConfig, Sight
from vpf_sim.perception.obstacles.point_hypotheses import Integers
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Bools, Camera, Floats, Flow


@dataclass(frozen=True, slots=True)
class MovingObstacleConfig:
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
    least_upright: int = 5  # points above the horizon that contrast is measured by
    most_suspects: int = 3  # that are looked at beside those believed
    least_points: int = 2  # that raise suspicion
    least_members: int = 4  # of a look that speaks for a body
    stray: float = 0.35  # what a track counts against a body that nothing explains: rain slides down the glass
    least_thickness_m: float = 0.2  # of its points about a line: tracks slip along lines
    least_height_m: float = 0.4  # from its lowest to its highest point
    front_m: float = 0.8  # of its face, and so of its width
    foot_m: float = 0.4  # its lowest point is not higher
    least_width_m: float = 1.3
    least_mps: float = 2.0  # of a body that is believed
    follow_m: float = 4.0  # nearer than this a body reaches beyond the picture, and is predicted,
    follow_bearing: float = 0.7  # as beyond this tangent
    side_quantile: float = 0.05  # of its points, that make its sides
    link_m: float = 1.1  # half an outline's width
    foot_side_m: float = 0.9  # from its middle to a foot at its side
    glass_m: float = 0.3  # of a vehicle, below the camera and up: windows show what is behind
    alike_ratio: float = 0.15
    slowest_share: float = 0.65  # of the closing speed in the own speed,
    equal_share: float = 0.1  # and least
    length_m: float = 4.5  # of a body
    nearest_m: float = 1.0  # from where on the side of one beside us is in the picture
    bright: tuple[float, float] = (-1.5, -0.8)  # contrast of points that count least, and in full, for who is suspected
    least_bright: float = 0.1
    steep_m: float = 6.0  # nearer than this the road is looked at too steeply to mirror a body
    mirrored_m: float = 60.0  # as far the road is known well enough to tell whether what it would mirror stands on it
    same_m: float = 1.2  # two that are nearer across are one, where the nearer is predicted
    margin_m: float = 0.3  # about it,
    about_m: float = 1.0  # and beyond that its sides are looked for
    tallest_m: float = 3.6
    prior: float = -4.0  # log-odds of what is suspected,
    dropped: float = -6.0  # and where it is no more
    speaks_against: float = 1.0  # change of the log-odds by a look at nothing upright
    doubts: float = 0.35  # at most against a body that is believed: the wiper passes, or another body
    independent_s: float = 0.1  # between looks that count in full
    believed: float = 1.0  # log-odds
    sure: float = 3.0  # from here on its points are no landmarks
    most: float = 6.0
    fade_per_s: float = 0.25  # of the log-odds while it cannot be looked at
    vague_m: float = 15.0  # standard deviation of the distance, and
    behind_m: float = 25.0  # where it is forgotten
    edge_line_m: float = 0.4  # points whose foot lies so near the edge line inside,
    verge_m: float = 1.8  # and so near outside, found no body
    edge_margin_m: float = 1.0  # inside the carriageway's edges is its middle
    noise: NoiseModel = field(default_factory=NoiseModel)  # of the tracks
    filter: FilterConfig = field(default_factory=FilterConfig)
    evidence: EvidenceConfig = field(default_factory=EvidenceConfig)
    closing: CollisionAlarmConfig = field(default_factory=CollisionAlarmConfig)

    def __post_init__(self) -> None:
        if not self.bright[0] < self.bright[1]:
            raise ValueError(f"bright: expected two increasing contrasts, got {self.bright}")
        if not 0.0 < self.least_bright <= 1.0:
            raise ValueError(f"least_bright: expected in (0, 1], got {self.least_bright}")


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
    contrast: Floats  # (N,) logarithm of their gradients' square, as a share of that of what stands upright


def appear(flow: Flow, points: Triangulation, camera: Camera, rate_hz: float, config: MovingObstacleConfig) -> Apparent:
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
    strength = np.log(np.maximum(flow.structure[:, 0, 0] + flow.structure[:, 1, 1], 1.0))
    upright = ripe & ~flow.stuck & (drop < 0.0)
    if np.count_nonzero(upright) < config.least_upright:
        upright = ripe & ~flow.stuck
    contrast = strength - (median(strength[upright]) if upright.any() else 0.0)
    return Apparent(inverse, sigma, drop, x, own, ripe, flow.stuck, road, standing, moves, contrast)


def outlines(seen: Apparent, feet: Integers, most: int, camera: Camera, config: MovingObstacleConfig) -> list[Integers]:
    """For the best of the suspected feet, the tracks that move as it does in the outline of a vehicle on it."""
    ripe = np.flatnonzero(seen.ripe & ~seen.still & (seen.drop > 0.0))
    middle = np.repeat(np.array([-1.0, 0.0, 1.0]) * config.foot_side_m, len(feet))[:, None]
    feet = np.tile(feet, 3)
    depth = camera.height_m / seen.drop[feet][:, None]
    inside = np.abs((seen.bearing[ripe] - seen.bearing[feet][:, None]) * depth - middle) < config.link_m
    inside &= (seen.drop[ripe] < 1.03 * seen.drop[feet][:, None]) & (seen.drop[ripe] * depth > config.glass_m)
    gap = np.abs(seen.inverse_per_m[ripe] - seen.inverse_per_m[feet][:, None])
    doubt = 3.0 * np.hypot(seen.sigma_per_m[ripe], seen.sigma_per_m[feet][:, None])
    alike = inside & (gap < doubt + config.alike_ratio * np.abs(seen.inverse_per_m[feet][:, None]))
    bright = np.interp(seen.contrast[ripe], config.bright, (config.least_bright, 1.0))  # mirror images are faint
    found: list[Integers] = []
    while len(found) < most:
        count = np.count_nonzero(alike, axis=1)
        stands = np.count_nonzero(inside & ~alike & (seen.standing[ripe] < config.chi2_limit), axis=1)
        stray = np.count_nonzero(inside & ~alike, axis=1) - stands
        good = (count >= config.least_members) & (count >= stands + config.stray * stray)
        if not good.any():
            break
        best = int(np.argmax(np.where(good, (alike * bright).sum(axis=1), 0.0)))
        mine = alike[best]
        if float(np.ptp(seen.drop[ripe[mine]])) * float(depth[best, 0]) > config.least_height_m:
            found.append(ripe[mine])
        inside, alike = inside & ~mine, alike & ~mine
    return found


def suspect(seen: Apparent, mine: Integers, camera: Camera, config: MovingObstacleConfig) -> Sight:
    """What the tracks in an outline tell of the body."""
    depth = (camera.height_m - config.filter.foot_height_m) / float(np.sort(seen.drop[mine])[-2:].mean())
    own = median(seen.own_mps[mine])
    share = median(seen.inverse_per_m[mine]) * depth
    across = seen.bearing[mine] * depth
    middle, half = 0.5 * (across.min() + across.max()), max(0.9, 0.5 * float(np.ptp(across)))
    return Sight(depth, own * (1.0 - share), 0.5 + 0.2 * own * abs(share), float(middle - half), float(middle + half))
