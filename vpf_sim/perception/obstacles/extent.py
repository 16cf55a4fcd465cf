"""Face and sides of obstacles, from their points and the errors of these."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vpf_sim.perception.obstacles.config import (
    FragmentConfig,
    SharpestConfig,
    SideOutlierConfig,
    SplitConfig,
    StaticObstacleConfig,
)
from vpf_sim.perception.road.geometry import direction_rad
from vpf_sim.types import Bools, Floats, Integers, RoadEdges


@dataclass(frozen=True, slots=True)
class ObstaclePoints:
    """M points of K obstacles, in vehicle axes or turned by the road's direction."""

    place_m: Floats  # (M, 2)
    sigma_m: Floats  # (M,) of the depth
    sight_rad: Floats  # (M,) direction of sight to the right of ahead, along which the place errs
    rim_m: Floats  # (M,) half a flow window at the point: it may follow an edge this far beside it
    alone: Bools  # (M,) obstacles by themselves
    outlier: Bools  # (M,) define no side

    @property
    def depth_sigma_m(self) -> Floats:
        """(M,) standard deviation of the depth: the surface itself is rough by 0.05 m."""
        return np.maximum(self.sigma_m, 0.05)


def front(points: ObstaclePoints, label: Integers, count: int) -> tuple[Floats, Floats]:
    """(K,) m, where the nearest quarter of the points' weight ends, and its standard deviation.

    `label` (M,) has the obstacle of each point. The nearest point is the one that errs most.
    """
    forward, sigma = points.place_m[:, 0], points.depth_sigma_m
    order = np.lexsort((forward, label))
    weight = sigma[order] ** -2
    total = np.bincount(label, sigma**-2, count)
    first = np.searchsorted(label[order], np.arange(count))
    passed = np.cumsum(weight) - 0.5 * weight
    before = np.concatenate([[0.0], np.cumsum(weight)])[first]
    place = [
        np.interp(before[k] + 0.25 * total[k], passed[i:j], forward[order[i:j]])
        for k, (i, j) in enumerate(pairwise([*first.tolist(), len(order)]))
    ]
    return np.array(place), 1.0 / np.sqrt(total)


def corrected_front(points: ObstaclePoints, label: Integers, count: int) -> tuple[Floats, Floats]:
    """(K,) m, `front` without the points' errors: a quarter of those on one face errs by 0.674 sigma or more."""
    forward = points.place_m[:, 0] + 0.674 * points.depth_sigma_m
    return front(replace(points, place_m=np.stack([forward, points.place_m[:, 1]], axis=1)), label, count)


def nearest_corner(points: ObstaclePoints, label: Integers, face_m: Floats, several: int, sigmas: float) -> Floats:
    """(K,) m, the face of each obstacle, or nearer where several points surely lie before it, by these `sigmas`.

    The corner of an obstacle at an angle, and one close before another, have few points.
    """
    beyond = points.place_m[:, 0] + sigmas * points.depth_sigma_m
    order = np.lexsort((beyond, label))
    first = np.searchsorted(label[order], np.arange(len(face_m) + 1))
    last = first[:-1] + several - 1
    enough = last < first[1:]
    begin = face_m.copy()
    begin[enough] = np.minimum(face_m[enough], beyond[order[last[enough]]])
    return begin


def sides(
    points: ObstaclePoints, label: Integers, face_m: Floats, config: StaticObstacleConfig
) -> tuple[Floats, Floats]:
    """(K,) m, left and right side of each obstacle, from points that are well known across.

    A point of poor depth defines a side well if its line of sight leads along the obstacle. The far side ends with
    the face: points beside it farther away slide along that edge.
    """
    count = len(face_m)
    aside = points.sigma_m * np.abs(np.sin(points.sight_rad))
    aside[points.outlier] = np.inf
    sharpest = np.full(count, np.inf)
    np.minimum.at(sharpest, label, aside)
    least_m = config.sharp_side.sigma_m if config.sharp_side else np.finfo(np.float64).max
    sharp = np.flatnonzero(aside <= np.maximum(least_m, 2.0 * sharpest[label]))
    face, place, sight, label = face_m[label[sharp]], points.place_m[sharp], points.sight_rad[sharp], label[sharp]
    across, beyond = move_to_face(face, place, sight), np.maximum(place[:, 0] - face, 0.0) * _slope(sight)
    blur, alone = np.hypot(aside, points.rim_m)[sharp], points.alone[sharp]
    left = -_farthest(np.minimum(beyond, 0.0) - across, blur, alone, label, count, config)
    right = _farthest(across - np.maximum(beyond, 0.0), blur, alone, label, count, config)
    return np.minimum(left, right), np.maximum(left, right)  # crossed where all sharp points lie behind the face


def _farthest(
    outward_m: Floats, blur_m: Floats, alone: Bools, label: Integers, count: int, config: StaticObstacleConfig
) -> Floats:
    """(K,) m, how far out each obstacle reaches by its points (M,), each of which may be `blur_m` too far out."""
    if config.side_outlier is not None:
        kept = ~_lone_outermost(outward_m, alone, label, count, config.side_outlier)
        outward_m, blur_m, label = outward_m[kept], blur_m[kept], label[kept]
    reach = np.full(count, -np.inf)
    if config.sharpest is None:
        np.maximum.at(reach, label, outward_m)
    else:
        _reach_sharpest(reach, outward_m, blur_m, label, config.sharpest)
    return reach


def _lone_outermost(outward_m: Floats, alone: Bools, label: Integers, count: int, config: SideOutlierConfig) -> Bools:
    """(M,) the outermost of many points if all others lie much nearer, and it is no obstacle by itself."""
    order = np.lexsort((outward_m, label))
    end = np.searchsorted(label[order], np.arange(1, count + 1))
    many = np.bincount(label, minlength=count) >= config.points
    last, next_m = order[end[many] - 1], outward_m[order[end[many] - 2]]
    outermost = np.zeros(len(label), np.bool_)
    outermost[last[outward_m[last] - next_m > config.apart_m]] = True
    return outermost & ~alone


def _reach_sharpest(reach: Floats, outward_m: Floats, blur_m: Floats, label: Integers, config: SharpestConfig) -> None:
    """Extend `reach` (K,) to the sharpest points, and to others that lie farther out than their blur explains.

    An edge carries points beside it along, so observations from nearer define it better.
    """
    order = np.lexsort((blur_m, label))
    first = np.searchsorted(label[order], np.arange(len(reach) + 1))
    best = blur_m[order][np.minimum(first[:-1] + config.points, first[1:]) - 1]
    sharp = blur_m <= config.ratio * best[label]
    np.maximum.at(reach, label[sharp], outward_m[sharp])
    farther = outward_m - config.blurs * blur_m > reach[label]
    np.maximum.at(reach, label[farther], outward_m[farther])


def is_behind(points: ObstaclePoints, label: Integers, count: int, config: SplitConfig, sigmas: float) -> Bools:
    """(M,) points behind the face of their obstacle and beside all points near it: they are of another one.

    They are beside it wherever along their line of sight they lie.
    """
    face, _ = front(points, label, count)
    behind, across = points.place_m[:, 0] - face[label], points.place_m[:, 1]
    near = behind < np.maximum(config.step_m, sigmas * points.sigma_m)
    left, right = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(left, label[near], across[near])
    np.maximum.at(right, label[near], across[near])
    at_face = across - behind * _slope(points.sight_rad)
    beside = np.minimum(across, at_face) > right[label] + config.beside_m
    beside |= np.maximum(across, at_face) < left[label] - config.beside_m
    return ~near & beside & (np.cos(points.sight_rad) > 0.5)


def outliers(points: ObstaclePoints, group: Integers, sigma_m: float) -> Bools:
    """(M,) points of poor depth behind and beside their obstacle, each alone: the horizon, or a slipped track.

    `group` (M,) numbers the clusters of points that are behind, -1 for all others.
    """
    single: Bools = (np.bincount(group + 1)[group + 1] == 1) & (group >= 0)
    return single & (points.sigma_m > sigma_m) & ~points.alone


def direction_at(points: ObstaclePoints, label: Integers, count: int, road: RoadEdges) -> Floats:
    """(K,) rad to the right of ahead, the road's direction at each of `count` obstacles."""
    ahead = np.bincount(label, points.place_m[:, 0], count) / np.bincount(label, minlength=count)
    return direction_rad(ahead, road)


def rotate(points: ObstaclePoints, angle_rad: Floats) -> ObstaclePoints:
    """The points in axes that are turned to the right by an angle (M,)."""
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    forward, right = points.place_m.T
    place = np.stack([cosine * forward + sine * right, cosine * right - sine * forward], axis=1)
    return replace(points, place_m=place, sight_rad=points.sight_rad - angle_rad)


def rotate_back(along_m: Floats, left_m: Floats, right_m: Floats, angle_rad: Floats) -> tuple[Floats, Floats, Floats]:
    """(K,) m each: face, left and right side in vehicle axes, as wide as in axes turned by an angle (K,)."""
    middle, half = 0.5 * (left_m + right_m), 0.5 * (right_m - left_m)
    forward = np.cos(angle_rad) * along_m - np.sin(angle_rad) * middle
    aside = np.sin(angle_rad) * along_m + np.cos(angle_rad) * middle
    return forward, aside - half, aside + half


def fragments(
    ahead_m: Floats,
    left_m: Floats,
    right_m: Floats,
    angle_rad: Floats,
    identity: Integers,
    support: Integers,
    config: FragmentConfig,
) -> Bools:
    """(K,) clusters behind a larger one of the same `identity` (-1: none) that are no obstacles.

    `ahead_m` is from the camera, `angle_rad` the road's direction, `support` the number of points. A fragment is in
    line with the larger one along the road, hidden by it, or one point: points slide along its side and outline.
    """
    behind_m = ahead_m[:, None] - ahead_m[None]
    own = _same(identity) & (behind_m > config.behind_m) & (support[:, None] <= support[None])
    distance = np.maximum(ahead_m, 0.5)  # what is nearer to the camera hides nothing
    left, right = left_m / distance, right_m / distance
    hidden = (left[:, None] < right[None] + config.rim_rad) & (right[:, None] > left[None] - config.rim_rad)
    hidden &= ahead_m > 0.5
    middle, half = 0.5 * (left_m + right_m), 0.5 * (right_m - left_m)
    aside = np.cos(angle_rad) * (middle[:, None] - middle[None]) - np.sin(angle_rad) * behind_m
    in_line = (np.abs(aside) < half[:, None] + half[None] + config.beside_m) & (behind_m < config.length_m)
    found: Bools = np.any(own & (hidden | in_line | (support == 1)[:, None]), axis=1)
    return found


def stale_fragments(ahead_m: Floats, stale: Bools, label: Integers, identity: Integers, support: Integers) -> Bools:
    """(K,) clusters of `stale` (M,) points only, before a larger one of the same `identity` that is observed."""
    fresh = np.bincount(label, ~stale, len(identity)) > 0
    own = _same(identity) & fresh[None] & (support[:, None] < support[None])
    found: Bools = ~fresh & np.any(own & (ahead_m[:, None] < ahead_m[None]), axis=1)
    return found


def _same(identity: Integers) -> Bools:
    """(K, K) clusters of the same obstacle, -1 being none."""
    same: Bools = (identity[:, None] == identity[None]) & (identity >= 0)
    return same


def move_to_face(face_m: Floats, place_m: Floats, sight_rad: Floats) -> Floats:
    """(M,) m across, of points (M, 2) moved along their line of sight up to the face if they lie before it."""
    lacking = np.maximum(face_m - place_m[:, 0], 0.0)
    across: Floats = place_m[:, 1] + lacking * _slope(sight_rad)
    return across


def _slope(sight_rad: Floats) -> Floats:
    """(M,) m to the right for each ahead along lines of sight, as if none were turned by more than 60 degrees."""
    return np.asarray(np.sin(sight_rad) / np.maximum(np.cos(sight_rad), 0.5))
