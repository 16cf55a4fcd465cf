"""Face and sides of obstacles, from their points and the errors of these."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vpf_sim.perception.obstacles.static_obstacle_settings import FragmentConfig, SharpestConfig, SplitConfig
from vpf_sim.perception.road.geometry import direction_rad
from vpf_sim.types import Bools, Floats, Integers, RoadEdges


@dataclass(frozen=True, slots=True)
class ObstaclePoints:
    """M points of K obstacles, in vehicle axes or turned by the road's direction."""

    place_m: Floats  # (M, 2)
    sigma_m: Floats  # (M,) of the depth
    sight_rad: Floats  # (M,) direction of sight to the right of ahead, along which the place errs
    rim_m: Floats  # (M,) half a flow window at the point: it may follow an edge this far beside it

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


def sides(points: ObstaclePoints, label: Integers, face_m: Floats, config: SharpestConfig) -> tuple[Floats, Floats]:
    """(K,) m, left and right side of each obstacle, from the points seen from nearest.

    The far side ends with the face: points beside it farther away slide along that edge.
    """
    face, place, sight, count = face_m[label], points.place_m, points.sight_rad, len(face_m)
    across, beyond = move_to_face(face, place, sight), np.maximum(place[:, 0] - face, 0.0) * _slope(sight)
    blur = np.hypot(points.sigma_m * np.abs(np.sin(sight)), points.rim_m)
    left = -_reach(np.minimum(beyond, 0.0) - across, blur, label, count, config)
    right = _reach(across - np.maximum(beyond, 0.0), blur, label, count, config)
    return np.minimum(left, right), np.maximum(left, right)  # crossed where all points lie behind the face


def _reach(outward_m: Floats, blur_m: Floats, label: Integers, count: int, config: SharpestConfig) -> Floats:
    """(K,) m, how far out each obstacle reaches by its points (M,), each of which may be `blur_m` too far out.

    An edge carries points beside it along, so observations from nearer define it better.
    """
    reach = np.full(count, -np.inf)
    order = np.lexsort((blur_m, label))
    first = np.searchsorted(label[order], np.arange(count + 1))
    best = blur_m[order][np.minimum(first[:-1] + config.points, first[1:]) - 1]
    sharp = blur_m <= config.ratio * best[label]
    np.maximum.at(reach, label[sharp], outward_m[sharp])
    farther = outward_m - config.blurs * blur_m > reach[label]
    np.maximum.at(reach, label[farther], outward_m[farther])
    return reach


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
    own = (identity[:, None] == identity[None]) & (identity >= 0)
    own &= (behind_m > config.behind_m) & (support[:, None] <= support[None])
    distance = np.maximum(ahead_m, 0.5)  # what is nearer to the camera hides nothing
    left, right = left_m / distance, right_m / distance
    hidden = (left[:, None] < right[None] + config.rim_rad) & (right[:, None] > left[None] - config.rim_rad)
    hidden &= ahead_m > 0.5
    middle, half = 0.5 * (left_m + right_m), 0.5 * (right_m - left_m)
    aside = np.cos(angle_rad) * (middle[:, None] - middle[None]) - np.sin(angle_rad) * behind_m
    in_line = (np.abs(aside) < half[:, None] + half[None] + config.beside_m) & (behind_m < config.length_m)
    found: Bools = np.any(own & (hidden | in_line | (support == 1)[:, None]), axis=1)
    return found


def move_to_face(face_m: Floats, place_m: Floats, sight_rad: Floats) -> Floats:
    """(M,) m across, of points (M, 2) moved along their line of sight up to the face if they lie before it."""
    lacking = np.maximum(face_m - place_m[:, 0], 0.0)
    across: Floats = place_m[:, 1] + lacking * _slope(sight_rad)
    return across


def _slope(sight_rad: Floats) -> Floats:
    """(M,) m to the right for each ahead along lines of sight, as if none were turned by more than 60 degrees."""
    return np.asarray(np.sin(sight_rad) / np.maximum(np.cos(sight_rad), 0.5))
