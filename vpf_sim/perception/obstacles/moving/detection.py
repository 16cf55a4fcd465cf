"""Points that seem to lie below the road, where no static point does, and candidates of vehicles among them."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.geometry import normalised
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import MovingObstacleConfig
from vpf_sim.perception.obstacles.moving.track import Detection
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers


@dataclass(frozen=True, slots=True)
class MeasuredPoints:
    """N tracked points, triangulated as if they stood still."""

    inverse_per_m: Floats  # (N,) from the camera, + is ahead
    sigma_per_m: Floats  # (N,)
    drop: Floats  # (N,) tangent below the horizon
    bearing: Floats  # (N,) tangent, + is right
    own_mps: Floats  # (N,) own mean speed since the first sighting
    ripe: Bools  # (N,) observed over enough travel
    still: Bools  # (N,) without motion: on the windscreen, or of a vehicle as fast as ours
    standing: Floats  # (N,) chi2 as a static point
    moves: Bools  # (N,) lies below the road
    contrast: Floats  # (N,) logarithm of the squared gradients, relative to upright objects


def measure(
    flow: Flow, points: Triangulation, camera: Camera, rate_hz: float, config: MovingObstacleConfig
) -> MeasuredPoints:
    """The tracked points, and which of them are no static points."""
    x, y = normalised(camera, flow.points_px)
    drop = np.cos(camera.pitch_rad) * y + np.sin(camera.pitch_rad)
    below = drop / camera.height_m
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse, sigma = points.inverse_per_m, points.inverse_sigma_per_m
        way = np.hypot(*(flow.pose[:2] - flow.first_pose[:, :2]).T)
        own = np.maximum(way * rate_hz / np.maximum(flow.age_frames, 1), 0.1)
        ripe = (way > config.least_baseline_m) & np.isfinite(inverse)
        moves = ripe & ~flow.on_glass & (drop > config.least_drop)
        moves &= points.chi2 < np.maximum(config.filter.chi2_limit, config.chi2_ratio * points.chi2_ground)
        moves &= inverse + 3.0 * sigma < (1.0 - config.below_ratio) * below
        moves &= points.chi2_ground - points.chi2 > config.chi2_margin
        standing = np.where(inverse < below, points.chi2_ground, points.chi2)
    strength = np.log(np.maximum(flow.structure[:, 0, 0] + flow.structure[:, 1, 1], 1.0))
    upright = ripe & ~flow.on_glass & (drop < 0.0)
    if np.count_nonzero(upright) < 5:  # the median of fewer is not reliable
        upright = ripe & ~flow.on_glass
    contrast = strength - (median(strength[upright]) if upright.any() else 0.0)
    return MeasuredPoints(inverse, sigma, drop, x, own, ripe, flow.on_glass, standing, moves, contrast)


def candidates(
    seen: MeasuredPoints, feet: Integers, most: int, camera: Camera, config: MovingObstacleConfig
) -> list[Integers]:
    """For the best of the feet (F,), the points in a vehicle's outline about it that move alike."""
    ripe = np.flatnonzero(seen.ripe & ~seen.still & (seen.drop > 0.0))
    middle = np.repeat(np.array([-1.0, 0.0, 1.0]) * config.half_width_m, len(feet))[:, None]
    feet = np.tile(feet, 3)
    depth = camera.height_m / seen.drop[feet][:, None]
    inside = np.abs((seen.bearing[ripe] - seen.bearing[feet][:, None]) * depth - middle) < config.link_m
    inside &= (seen.drop[ripe] < config.foot_ratio * seen.drop[feet][:, None]) & (
        seen.drop[ripe] * depth > config.glass_m
    )
    gap = np.abs(seen.inverse_per_m[ripe] - seen.inverse_per_m[feet][:, None])
    doubt = 3.0 * np.hypot(seen.sigma_per_m[ripe], seen.sigma_per_m[feet][:, None])
    alike = inside & (gap < doubt + config.alike_ratio * np.abs(seen.inverse_per_m[feet][:, None]))
    found: list[Integers] = []
    while len(found) < most:
        good = np.count_nonzero(alike, axis=1) >= config.least_members
        if not good.any():
            break
        best = int(np.argmax(np.where(good, np.count_nonzero(alike, axis=1), 0)))
        mine = alike[best]
        if float(np.ptp(seen.drop[ripe[mine]])) * float(depth[best, 0]) > config.shape.least_height_m:
            found.append(ripe[mine])
        alike = alike & ~mine
    return found


def detect(seen: MeasuredPoints, mine: Integers, camera: Camera, config: MovingObstacleConfig) -> Detection:
    """Place, speed and width of a candidate with the points `mine`."""
    depth = (camera.height_m - config.filter.foot_height_m) / float(np.sort(seen.drop[mine])[-2:].mean())
    own = median(seen.own_mps[mine])
    share = median(seen.inverse_per_m[mine]) * depth
    across = seen.bearing[mine] * depth
    middle, half = 0.5 * (across.min() + across.max()), max(config.half_width_m, 0.5 * float(np.ptp(across)))
    sigma = config.speed_sigma_mps + config.speed_sigma_ratio * own * abs(share)
    return Detection(depth, own * (1.0 - share), sigma, float(middle - half), float(middle + half))
