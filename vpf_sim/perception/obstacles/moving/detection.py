"""Tracked points that lie below the road, where nothing standing does, and the candidates that they make."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.moving.config import MovingObstacleConfig
from vpf_sim.perception.obstacles.moving.track import Detection
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers


@dataclass(frozen=True, slots=True)
class Apparent:
    """N tracked points, triangulated as if they stood."""

    inverse_per_m: Floats  # (N,) from the camera, + is ahead
    sigma_per_m: Floats  # (N,)
    drop: Floats  # (N,) tangent below the horizon
    bearing: Floats  # (N,) tangent, + is right
    own_mps: Floats  # (N,) own mean speed since the first sighting
    ripe: Bools  # (N,) observed over enough own way
    still: Bools  # (N,) on the windscreen, or of a vehicle as fast as the camera
    standing: Floats  # (N,) chi2 as a point that stands or lies on the road
    moves: Bools  # (N,) lies below the road
    contrast: Floats  # (N,) logarithm of the squared gradients, relative to upright objects


def appear(flow: Flow, points: Triangulation, camera: Camera, rate_hz: float, config: MovingObstacleConfig) -> Apparent:
    """The tracked points, and which of them nothing standing explains."""
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
        moves &= points.chi2 < np.maximum(config.filter.chi2_limit, config.chi2_ratio * points.chi2_ground)
        moves &= inverse + 3.0 * sigma < (1.0 - config.below_ratio) * below
        moves &= points.chi2_ground - points.chi2 > config.chi2_margin
        standing = np.where(inverse < below, points.chi2_ground, points.chi2)
    strength = np.log(np.maximum(flow.structure[:, 0, 0] + flow.structure[:, 1, 1], 1.0))
    upright = ripe & ~flow.stuck & (drop < 0.0)
    if np.count_nonzero(upright) < config.least_upright:
        upright = ripe & ~flow.stuck
    contrast = strength - (median(strength[upright]) if upright.any() else 0.0)
    return Apparent(inverse, sigma, drop, x, own, ripe, flow.stuck, standing, moves, contrast)


def candidates(
    seen: Apparent, feet: Integers, most: int, camera: Camera, config: MovingObstacleConfig
) -> list[Integers]:
    """For the best of the feet (F,), the points that move alike in a vehicle's outline about it."""
    ripe = np.flatnonzero(seen.ripe & ~seen.still & (seen.drop > 0.0))
    middle = np.repeat(np.array([-1.0, 0.0, 1.0]) * config.foot_side_m, len(feet))[:, None]
    feet = np.tile(feet, 3)
    depth = camera.height_m / seen.drop[feet][:, None]
    inside = np.abs((seen.bearing[ripe] - seen.bearing[feet][:, None]) * depth - middle) < config.link_m
    inside &= (seen.drop[ripe] < config.foot_ratio * seen.drop[feet][:, None]) & (
        seen.drop[ripe] * depth > config.glass_m
    )
    gap = np.abs(seen.inverse_per_m[ripe] - seen.inverse_per_m[feet][:, None])
    doubt = 3.0 * np.hypot(seen.sigma_per_m[ripe], seen.sigma_per_m[feet][:, None])
    alike = inside & (gap < doubt + config.alike_ratio * np.abs(seen.inverse_per_m[feet][:, None]))
    least_m = config.shape.least_height_m if config.shape else -np.inf
    found: list[Integers] = []
    while len(found) < most:
        good = _is_supported(inside, alike, seen.standing[ripe], config)
        if not good.any():
            break
        best = int(np.argmax(np.where(good, (alike * _weight(seen.contrast[ripe], config)).sum(axis=1), 0.0)))
        mine = alike[best]
        if float(np.ptp(seen.drop[ripe[mine]])) * float(depth[best, 0]) > least_m:
            found.append(ripe[mine])
        inside, alike = inside & ~mine, alike & ~mine
    return found


def _is_supported(inside: Bools, alike: Bools, standing: Floats, config: MovingObstacleConfig) -> Bools:
    """(F,) outlines with enough points that move alike, (F, N), against the others that lie inside."""
    count = np.count_nonzero(alike, axis=1)
    supported: Bools = count >= config.least_members
    if config.contradiction is not None:
        stands = np.count_nonzero(inside & ~alike & (standing < config.filter.chi2_limit), axis=1)
        stray = np.count_nonzero(inside & ~alike, axis=1) - stands
        supported &= count >= stands + config.contradiction.stray * stray
    return supported


def _weight(contrast: Floats, config: MovingObstacleConfig) -> Floats:
    """(N,) weights of points in the choice of a candidate: mirror images are faint."""
    rule = config.candidate_contrast
    if rule is None:
        return np.ones(len(contrast))
    return np.interp(contrast, rule.contrast, (rule.least, 1.0))


def detect(seen: Apparent, mine: Integers, camera: Camera, config: MovingObstacleConfig) -> Detection:
    """The place, speed and width of a candidate with the points `mine`."""
    depth = (camera.height_m - config.filter.foot_height_m) / float(np.sort(seen.drop[mine])[-2:].mean())
    own = median(seen.own_mps[mine])
    share = median(seen.inverse_per_m[mine]) * depth
    across = seen.bearing[mine] * depth
    middle, half = 0.5 * (across.min() + across.max()), max(config.least_half_m, 0.5 * float(np.ptp(across)))
    sigma = config.speed_sigma_mps + config.speed_sigma_ratio * own * abs(share)
    return Detection(depth, own * (1.0 - share), sigma, float(middle - half), float(middle + half))
