"""Where a body begins and how wide it is, from points of it that are known more or less well."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vpf_sim.geometry import vehicle_from_world, world_from_vehicle
from vpf_sim.perception.obstacles.config import (
    FragmentConfig,
    NearCornerConfig,
    SharpestConfig,
    SideOutlierConfig,
    SplitConfig,
    StaticObstacleConfig,
)
from vpf_sim.perception.obstacles.point_hypotheses import Integers
from vpf_sim.perception.road.geometry import direction_rad
from vpf_sim.types import Bools, Floats, Obstacles, RoadEdges

LEAST_SIGMA_M = 0.05  # no point of a body tells its face better
NEAREST_M = 0.5  # a body nearer to the camera hides nothing
RIM_RAD, RIM_M = 0.02, 0.3  # beside one, what is seen is mixed with it
SAME_ALONG_M = 2.0  # what begins so far behind may be of the same body
LEAST_COSINE = 0.5  # of a line of sight to the road
NEARER_SHARE = 0.25  # of the points' weight before a body's face


@dataclass(frozen=True, slots=True)
class Seen:
    """M points of bodies, in vehicle axes."""

    place_m: Floats  # (M, 2)
    sigma_m: Floats  # (M,) of the depth
    sight_rad: Floats  # (M,) to the right of ahead, the direction in which a point was seen, and its place may err
    rim_m: Floats  # (M,) half a window of the flow when it was seen: the edge that it follows may be so far beside it
    alone: Bools  # (M,) those that would be bodies without the others
    stray: Bools  # (M,) those that tell no side, see `strays`


def to_current_frame(bodies: Obstacles, seen_from: Floats, pose: Floats, speed_mps: float) -> Obstacles:
    """Bodies seen from a pose short before, in the axes of the vehicle now, with their time to contact, as if none had
    moved since."""
    if not len(bodies):
        return bodies
    middle = bodies.middle_m
    place = np.stack([bodies.forward_m, middle], axis=1)
    place = vehicle_from_world(world_from_vehicle(place, seen_from), pose)
    face, aside, closing = place[:, 0], place[:, 1] - middle, np.maximum(speed_mps - bodies.speed_mps, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ttc = np.where((face > 0.0) & (closing > 0.0), face / closing, np.inf)
    return replace(bodies, forward_m=face, left_m=bodies.left_m + aside, right_m=bodies.right_m + aside, ttc_s=ttc)


def carried(
    bodies: Obstacles, seen_from: Floats, pose: Floats, speed_mps: float, road: RoadEdges, since_s: float
) -> Obstacles:
    """The same, with the way along the road that those which move have gone in the time since."""
    if bodies.speed_mps.any():
        way, angle = bodies.speed_mps * since_s, direction_rad(bodies.forward_m, road)
        forward, aside = np.cos(angle) * way, np.sin(angle) * way
        bodies = replace(
            bodies,
            forward_m=bodies.forward_m + forward,
            left_m=bodies.left_m + aside,
            right_m=bodies.right_m + aside,
        )
    return to_current_frame(bodies, seen_from, pose, speed_mps)


def widened(bodies: Obstacles, width_m: float | Floats) -> Obstacles:
    """The bodies (K,) at least so wide each, about their middle."""
    if not len(bodies):
        return bodies
    lacking = 0.5 * np.maximum(width_m - bodies.width_m, 0.0)
    return replace(bodies, left_m=bodies.left_m - lacking, right_m=bodies.right_m + lacking)


def _apart_m(ones: Obstacles, others: Obstacles) -> Floats:
    """(K, M) m across the road between each of K bodies and each of M others; < 0 where they overlap."""
    return np.maximum(others.left_m - ones.right_m[:, None], ones.left_m[:, None] - others.right_m)


def nearest_spot(points: Obstacles, spots: Obstacles, along_m: float, beside_m: float) -> tuple[Integers, Bools]:
    """(K,) which spot of the road's comparison is nearest to each body that low points tell of, and whether it is as
    near as `beside_m`."""
    if not len(points) or not len(spots):
        return np.zeros(len(points), np.int64), np.zeros(len(points), np.bool_)
    along = np.abs(points.forward_m[:, None] - spots.forward_m[None])
    apart = np.where(along < along_m, _apart_m(points, spots), np.inf)
    return apart.argmin(axis=1), apart.min(axis=1) < beside_m


def widened_to_observation(points: Obstacles, spots: Obstacles, nearest: Integers, seen: Bools) -> Obstacles:
    """Bodies that low points tell of, each as wide as its `nearest_spot`, where that is near.

    Points show a part of a low body, but well where that is: the spot is moved as far as it must be to hold them.
    """
    if not seen.any():
        return points
    left, right, width = spots.left_m[nearest], points.right_m, spots.width_m[nearest]
    begins = np.minimum(np.maximum(left, right - width), points.left_m)
    return replace(
        points,
        left_m=np.where(seen, begins, points.left_m),
        right_m=np.where(seen, np.maximum(begins + width, right), right),
    )


def on_top(tall: Obstacles, low: Obstacles, before_m: float) -> Obstacles:
    """The tall ones, with the low one whose upper edge they are: one that is wider, and that they overlap.

    Seen from afar, a few points of a pallet seem to stand higher than it does, and so nearer.
    """
    if not len(tall) or not len(low):
        return tall
    face, left, right = tall.forward_m.copy(), tall.left_m.copy(), tall.right_m.copy()
    behind = low.forward_m[:, None] - tall.forward_m[None]
    under_it = (_apart_m(low, tall) < 0.0) & (low.width_m[:, None] > tall.width_m)
    for under, above in np.argwhere((behind > -before_m) & (behind < SAME_ALONG_M) & under_it):
        left[above], right[above] = min(left[above], low.left_m[under]), max(right[above], low.right_m[under])
        face[above] = min(face[above], low.forward_m[under])
    return replace(tall, forward_m=face, left_m=left, right_m=right)


def joined(
    tall: Obstacles, low: Obstacles, beside_m: float, sticks_out_m: float | Floats, before_m: float
) -> Obstacles:
    """Both, without the low ones beside or under a tall one: but what sticks out of it to a side by more than
    `sticks_out_m`, of all or of each (K,), or begins farther before its face than `before_m`, is a body of its own."""
    if not len(low):
        return tall
    if not len(tall):
        return low
    left, right = low.left_m[:, None], low.right_m[:, None]
    out = np.maximum(tall.left_m[None] - left, right - tall.right_m[None])
    behind = low.forward_m[:, None] - tall.forward_m[None]
    along = (behind > -before_m) & (behind < SAME_ALONG_M)
    own = low.chosen(~np.any((_apart_m(low, tall) < beside_m) & (out < sticks_out_m) & along, axis=1))
    return tall.concatenate(own)


def nearest_extent(seen: Seen, label: Integers, count: int) -> tuple[Floats, Floats]:
    """(K,) m, where each of `count` bodies begins, and its standard deviation; `label` (M,) tells whose a point is.

    Most points of a body that is seen from behind lie on its face, and the nearest of them is the one that errs most.
    So it begins where a quarter of the points' weight lies nearer.
    """
    forward, sigma = seen.place_m[:, 0], np.maximum(seen.sigma_m, LEAST_SIGMA_M)
    order = np.lexsort((forward, label))
    weight = sigma[order] ** -2
    total = np.bincount(label, sigma**-2, count)
    first = np.searchsorted(label[order], np.arange(count))
    passed = np.cumsum(weight) - 0.5 * weight
    before = np.concatenate([[0.0], np.cumsum(weight)])[first]
    place = [
        np.interp(before[k] + NEARER_SHARE * total[k], passed[i:j], forward[order[i:j]])
        for k, (i, j) in enumerate(pairwise([*first.tolist(), len(order)]))
    ]
    return np.array(place), 1.0 / np.sqrt(total)


def face_of(seen: Seen, label: Integers, count: int, sigmas: float) -> tuple[Floats, Floats]:
    """(K,) m, the face of each body, and its standard deviation: `nearest_extent` without what the points err by.

    A quarter of those that lie on one face err by so many standard deviations or more: each is moved by as much.
    """
    forward = seen.place_m[:, 0] + sigmas * np.maximum(seen.sigma_m, LEAST_SIGMA_M)
    return nearest_extent(replace(seen, place_m=np.stack([forward, seen.place_m[:, 1]], axis=1)), label, count)


def nearest_sure(seen: Seen, label: Integers, face_m: Floats, config: NearCornerConfig) -> Floats:
    """(K,) m, where each body begins: at its face, or nearer where several of its points lie nearer beyond doubt.

    The corner of a body that stands at an angle and one close before another have few points beside those of the rest.
    """
    beyond = seen.place_m[:, 0] + config.sigmas * np.maximum(seen.sigma_m, LEAST_SIGMA_M)
    order = np.lexsort((beyond, label))
    first = np.searchsorted(label[order], np.arange(len(face_m) + 1))
    several = first[:-1] + config.points - 1
    enough = several < first[1:]
    begin = face_m.copy()
    begin[enough] = np.minimum(face_m[enough], beyond[order[several[enough]]])
    return begin


def sides(seen: Seen, label: Integers, face_m: Floats, config: StaticObstacleConfig) -> tuple[Floats, Floats]:
    """(K,) m, where the left and the right side of each body is, from its points that are known well across.

    A point of poor depth still tells a side well if it was seen along the body; one seen at an angle would stretch it.
    The side that is turned away is where the face ends: what shows beside it farther away slides along that edge.
    """
    count = len(face_m)
    aside = seen.sigma_m * np.abs(np.sin(seen.sight_rad))  # a place errs along the line of sight
    aside[seen.stray] = np.inf
    sharp_m = config.sharp_side.sigma_m if config.sharp_side else np.finfo(np.float64).max
    well = np.flatnonzero(_known_well(aside, sharp_m, label, count))
    face, place, sight = face_m[label[well]], seen.place_m[well], seen.sight_rad[well]
    across, beyond = at_least(face, place, sight), np.maximum(place[:, 0] - face, 0.0) * slope(sight)
    blur, alone = np.hypot(aside, seen.rim_m)[well], seen.alone[well]
    left = -_farthest(np.minimum(beyond, 0.0) - across, blur, alone, label[well], count, config)
    right = _farthest(across - np.maximum(beyond, 0.0), blur, alone, label[well], count, config)
    return np.minimum(left, right), np.maximum(left, right)  # crossed where all sharp points lie behind the face


def _astray(outward_m: Floats, alone: Bools, label: Integers, count: int, config: SideOutlierConfig) -> Bools:
    """(M,) the farthest point of a body of many where all others lie much nearer, and it would be none by itself."""
    order = np.lexsort((outward_m, label))
    end = np.searchsorted(label[order], np.arange(1, count + 1))
    many = np.bincount(label, minlength=count) >= config.points
    last, next_m = order[end[many] - 1], outward_m[order[end[many] - 2]]
    astray = np.zeros(len(label), np.bool_)
    astray[last[outward_m[last] - next_m > config.apart_m]] = True
    return astray & ~alone


def _farthest(
    outward_m: Floats, blur_m: Floats, alone: Bools, label: Integers, count: int, config: StaticObstacleConfig
) -> Floats:
    """(K,) m, how far out each body reaches by its points (M,), one at least, each `blur_m` too far out at most.

    An edge carries along what is seen beside it, so what was seen from nearer tells better where it is; but what was
    seen only from afar, and lies farther out than that explains, is of the body as well.
    """
    if config.side_outlier is not None:
        kept = ~_astray(outward_m, alone, label, count, config.side_outlier)
        outward_m, blur_m, label = outward_m[kept], blur_m[kept], label[kept]
    if config.sharpest is not None:
        return _farthest_sharp(outward_m, blur_m, label, count, config.sharpest)
    reach = np.full(count, -np.inf)
    np.maximum.at(reach, label, outward_m)
    return reach


def _farthest_sharp(outward_m: Floats, blur_m: Floats, label: Integers, count: int, config: SharpestConfig) -> Floats:
    order = np.lexsort((blur_m, label))
    first = np.searchsorted(label[order], np.arange(count + 1))
    best = blur_m[order][np.minimum(first[:-1] + config.points, first[1:]) - 1]
    sharp = blur_m <= config.ratio * best[label]
    reach = np.full(count, -np.inf)
    np.maximum.at(reach, label[sharp], outward_m[sharp])
    farther = outward_m - config.blurs * blur_m > reach[label]
    np.maximum.at(reach, label[farther], outward_m[farther])
    return reach


def stands_behind(seen: Seen, label: Integers, count: int, config: SplitConfig) -> Bools:
    """(M,) points behind the face of their body and beside all that lies near it, wherever along their line of sight
    they are: another body's, which from afar seemed to stand where this one does."""
    face, _ = nearest_extent(seen, label, count)
    behind, across = seen.place_m[:, 0] - face[label], seen.place_m[:, 1]
    near = behind < np.maximum(config.step_m, config.sigmas * seen.sigma_m)
    left, right = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(left, label[near], across[near])
    np.maximum.at(right, label[near], across[near])
    at_face = across - behind * slope(seen.sight_rad)
    beside = np.minimum(across, at_face) > right[label] + RIM_M
    beside |= np.maximum(across, at_face) < left[label] - RIM_M
    return ~near & beside & (np.cos(seen.sight_rad) > LEAST_COSINE)


def strays(seen: Seen, behind: Integers, sigma_m: float) -> Bools:
    """(M,) points known badly that stand behind their body and beside it, each by itself, and would be none alone.

    `behind` (M,) numbers the clusters of those that do (`stands_behind`), -1 for all others. Seen straight ahead such a
    point seems to lie well across, whatever stands there: the horizon, or what slides along the body's edge.
    """
    single: Bools = (np.bincount(behind + 1)[behind + 1] == 1) & (behind >= 0)
    return single & (seen.sigma_m > sigma_m) & ~seen.alone


def direction_at(seen: Seen, label: Integers, count: int, road: RoadEdges) -> Floats:
    """(K,) rad to the right of ahead, the road's direction where each of `count` bodies is."""
    ahead = np.bincount(label, seen.place_m[:, 0], count) / np.bincount(label, minlength=count)
    return direction_rad(ahead, road)


def turned(seen: Seen, angle_rad: Floats) -> Seen:
    """The points in axes that are turned to the right by an angle (M,), each by that of its body."""
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    forward, right = seen.place_m.T
    place = np.stack([cosine * forward + sine * right, cosine * right - sine * forward], axis=1)
    return replace(seen, place_m=place, sight_rad=seen.sight_rad - angle_rad)


def turned_back(along_m: Floats, left_m: Floats, right_m: Floats, angle_rad: Floats) -> tuple[Floats, Floats, Floats]:
    """(K,) m each: face, left and right side of bodies in vehicle axes, as wide as in axes turned by an angle (K,)."""
    middle, half = 0.5 * (left_m + right_m), 0.5 * (right_m - left_m)
    forward = np.cos(angle_rad) * along_m - np.sin(angle_rad) * middle
    aside = np.sin(angle_rad) * along_m + np.cos(angle_rad) * middle
    return forward, aside - half, aside + half


def parted(
    ahead_m: Floats,
    left_m: Floats,
    right_m: Floats,
    angle_rad: Floats,
    body: Integers,
    support: Integers,
    config: FragmentConfig,
) -> Bools:
    """(K,) clusters that parted from a nearer, larger one of the same `body` (-1: none) and are no body of their own.

    `ahead_m` is from the camera. Points along a body's side, and those that slide along its outline, seem to stand
    behind it: in line with it along the road, which leads `angle_rad` to the right of ahead there, in the strip that it
    hides, or one alone; `support` is their number.
    """
    behind_m = ahead_m[:, None] - ahead_m[None]
    own = _same(body) & (behind_m > config.behind_m) & (support[:, None] <= support[None])
    distance = np.maximum(ahead_m, NEAREST_M)
    hidden = _overlap(left_m / distance, right_m / distance, RIM_RAD) & (ahead_m > NEAREST_M)
    middle, half = 0.5 * (left_m + right_m), 0.5 * (right_m - left_m)
    aside = np.cos(angle_rad) * (middle[:, None] - middle[None]) - np.sin(angle_rad) * behind_m
    in_line = (np.abs(aside) < half[:, None] + half[None] + RIM_M) & (behind_m < config.length_m)
    no_body: Bools = np.any(own & (hidden | in_line | (support == 1)[:, None]), axis=1)
    return no_body


def outdated(ahead_m: Floats, old: Bools, label: Integers, body: Integers, support: Integers) -> Bools:
    """(K,) clusters of points that are all `old` (M,), in the picture and much nearer by now but not placed again,
    before a larger one of the same `body` (-1: none) that is seen: points of that one whose depth was wrong."""
    count = len(body)
    fresh = np.bincount(label, ~old, count) > 0
    own = _same(body) & fresh[None] & (support[:, None] < support[None])
    no_body: Bools = ~fresh & np.any(own & (ahead_m[:, None] < ahead_m[None]), axis=1)
    return no_body


def _same(body: Integers) -> Bools:
    """(K, K) clusters of the same body, -1 being none."""
    same: Bools = (body[:, None] == body[None]) & (body >= 0)
    return same


def _overlap(left: Floats, right: Floats, margin: float) -> Bools:
    """(K, K) whether intervals are nearer to each other than a margin."""
    near: Bools = (left[:, None] < right[None] + margin) & (right[:, None] > left[None] - margin)
    return near


def _known_well(sigma_m: Floats, sharp_m: float, label: Integers, count: int) -> Bools:
    """(M,) points that count for the extent of their body: the sharp, and those not much worse than its sharpest."""
    sharpest = np.full(count, np.inf)
    np.minimum.at(sharpest, label, sigma_m)
    well: Bools = sigma_m <= np.maximum(sharp_m, 2.0 * sharpest[label])
    return well


def at_least(forward_m: Floats, place_m: Floats, sight_rad: Floats) -> Floats:
    """(M,) m across, where points (M, 2) in vehicle axes lie when those nearer than `forward_m` are moved up to it.

    Nothing of a body lies before its face, and a place errs along the line of sight (to the right of ahead by
    `sight_rad`) in which the point was seen, not across it; the car may have turned since.
    """
    lacking = np.maximum(forward_m - place_m[:, 0], 0.0)
    across: Floats = place_m[:, 1] + lacking * slope(sight_rad)
    return across


def slope(sight_rad: Floats) -> Floats:
    """(M,) m to the right for each ahead along lines of sight, no more than 2: a car that has turned far sees some
    across the road, and along these nothing tells where a body's side is."""
    return np.asarray(np.sin(sight_rad) / np.maximum(np.cos(sight_rad), LEAST_COSINE))


def none() -> Obstacles:
    empty = np.empty(0)
    return Obstacles(empty, empty, empty, empty, empty, np.empty(0, np.int64))
