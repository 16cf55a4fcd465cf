"""Points a hand's breadth above the road, of pallets, planks, tyres; and low obstacles beside or under taller ones."""

from dataclasses import replace

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.static_obstacle_settings import LowObstacleConfig, NearbyConfig
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Integers, Obstacles, RoadEdges


def is_low(
    points: Triangulation, age_s: Floats, texture: Floats, config: LowObstacleConfig, far_m: float, chi2_limit: float
) -> Bools:
    """(N,) points a hand's breadth above the road; a single one of them proves little."""
    with np.errstate(invalid="ignore"):
        low = (points.depth_m > config.near_m) & (points.depth_m < far_m) & (age_s >= config.min_age_s)
        low &= texture > config.least_texture
        low &= (points.chi2 < chi2_limit) & (points.chi2_ground - points.chi2 > config.chi2_margin)
        low &= (points.height_m > config.min_height_m) & (points.height_m < config.max_height_m)
        low &= points.height_sigma_m < config.sigma_height_m
    return low


def off_lines(camera: Camera, foot_m: Floats, road: RoadEdges, config: LowObstacleConfig) -> Bools:
    """(N,) places (N, 2) on the flat road, vehicle axes, within the carriageway and on no painted line.

    Lines are a lane's width apart across the road; along the axes of a turned vehicle farther.
    """
    lane_width_m = road.lane_width_m
    left, right = carriageway_offsets(foot_m[:, 0], road)
    lanes = max(round((road.right_m - road.left_m) / lane_width_m), 1)
    across = (foot_m[:, 1] - left) / (right - left) * lanes
    aside = np.abs(across - np.rint(across)) * lane_width_m
    halo = config.line_px * (foot_m[:, 0] - camera.forward_m) / camera.fx_px
    is_edge = (np.rint(across) <= 0.0) | (np.rint(across) >= lanes)
    off: Bools = (across > 0.0) & (across < lanes) & (aside > np.where(is_edge, config.edge_m, config.line_m) + halo)
    return off


def belongs_to(place_m: Floats, parts_m: Floats, parts_of: Integers, tall: Obstacles, config: NearbyConfig) -> Bools:
    """(M,) low points (M, 2) beside a point (P, 2) of a taller obstacle, as wheels are, and not before its face.

    `parts_of` (P,) has the identities of these obstacles.
    """
    gap = np.abs(place_m[:, None] - parts_m)
    same = parts_of[:, None] == tall.identity
    face = np.min(np.broadcast_to(tall.forward_m, same.shape), axis=1, where=same, initial=np.inf)
    behind = place_m[:, :1] > face - config.along_m
    part: Bools = np.any((gap[..., 0] < config.along_m) & (gap[..., 1] < config.across_m) & behind, axis=1)
    return part


def widen(obstacles: Obstacles, width_m: float | Floats) -> Obstacles:
    """Obstacles (K,) with at least this width each, about their middle."""
    lacking = 0.5 * np.maximum(width_m - obstacles.width_m, 0.0)
    return replace(obstacles, left_m=obstacles.left_m - lacking, right_m=obstacles.right_m + lacking)


def widen_to_tracks(low: Obstacles, tracks: Obstacles, along_m: float, beside_m: float) -> Obstacles:
    """The obstacles of low points, each as wide as the nearest low track within these distances.

    Points show only a part of an obstacle, but at the right place: the track is shifted to contain them.
    """
    if not len(low) or not len(tracks):
        return low
    along = np.abs(low.forward_m[:, None] - tracks.forward_m)
    apart = np.where(along < along_m, _apart_m(low, tracks), np.inf)
    nearest, matched = apart.argmin(axis=1), apart.min(axis=1) < beside_m
    left, right, width = tracks.left_m[nearest], low.right_m, tracks.width_m[nearest]
    begin = np.minimum(np.maximum(left, right - width), low.left_m)
    return replace(
        low,
        left_m=np.where(matched, begin, low.left_m),
        right_m=np.where(matched, np.maximum(begin + width, right), right),
    )


def extend_by_low(tall: Obstacles, low: Obstacles, before_m: float, behind_m: float) -> Obstacles:
    """The tall obstacles, extended by wider low ones if they are the upper edge of these.

    From afar a few points of a pallet seem higher than it is, and so nearer.
    """
    if not len(tall) or not len(low):
        return tall
    face, left, right = tall.forward_m.copy(), tall.left_m.copy(), tall.right_m.copy()
    behind = low.forward_m[:, None] - tall.forward_m[None]
    under = (behind > -before_m) & (behind < behind_m)
    under &= (_apart_m(low, tall) < 0.0) & (low.width_m[:, None] > tall.width_m)
    for one, above in np.argwhere(under):
        left[above], right[above] = min(left[above], low.left_m[one]), max(right[above], low.right_m[one])
        face[above] = min(face[above], low.forward_m[one])
    return replace(tall, forward_m=face, left_m=left, right_m=right)


def join(
    tall: Obstacles,
    low: Obstacles,
    beside_m: float,
    sticks_out_m: float | Floats,
    before_m: float,
    behind_m: float,
) -> Obstacles:
    """Tall and low obstacles, without low ones beside or under a tall one.

    A low one that extends beyond its side by more than `sticks_out_m`, or lies farther before its face than
    `before_m` or behind than `behind_m`, is an obstacle of its own.
    """
    if not len(low) or not len(tall):
        return tall if len(tall) else low
    out = np.maximum(tall.left_m[None] - low.left_m[:, None], low.right_m[:, None] - tall.right_m[None])
    behind = low.forward_m[:, None] - tall.forward_m[None]
    part = (behind > -before_m) & (behind < behind_m) & (_apart_m(low, tall) < beside_m) & (out < sticks_out_m)
    return tall.concatenate(low.select(~np.any(part, axis=1)))


def _apart_m(ones: Obstacles, others: Obstacles) -> Floats:
    """(K, M) m across the road between each of K obstacles and each of M others; < 0 where they overlap."""
    return np.maximum(others.left_m - ones.right_m[:, None], ones.left_m[:, None] - others.right_m)
