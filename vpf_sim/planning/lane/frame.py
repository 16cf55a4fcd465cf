"""Lane coordinates: the one space in which the robust variant composes its fields.

`along` is measured from the pose along the road, `y` across it, from the middle of the own lane, + is right. The
camera's road edges give the transformation; nothing of a map enters.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from vpf_sim.types import Bools, Floats, LateralExtents, Obstacles, RoadEdges

BODY_M = (1.0, 6.0)  # so far behind its face a body may still go on,
BODY_BEYOND_M = 0.6  # and so far beyond its sides its points may stray;
BODY_SHARE = 0.5  # and what lies in its way with this share of its width is of it, since no two bodies are at one place
PARTS_OF_PARTS = 2  # doublings: a truck's side tells itself in up to four
# Bounds of lane coordinates, far beyond any road: whatever is told, sums and squares of what is planned by stay finite.
FAR_M, SHARPEST_PER_M, TURNED_RAD, FASTEST_MPS = 1e4, 1.0, 4.0, 1e3


@dataclass(frozen=True, slots=True)
class Lane:
    """The vehicle on the road, as the camera sees it."""

    y_m: float  # of the pose
    right_m: float  # y of the right edge
    left_m: float  # y of the left edge
    heading_rad: float  # direction of the road minus yaw
    curvature_per_m: float  # of the road at the pose, + bends right


@dataclass(frozen=True, slots=True)
class LaneObstacles(LateralExtents):
    """K bodies in lane coordinates."""

    along_m: Floats  # (K,) nearest face, from the pose
    left_m: Floats  # (K,) y of the left side
    right_m: Floats  # (K,) y of the right side
    speed_mps: Floats = field(default_factory=lambda: np.empty(0))  # (K,) along the road; left out, all stand
    length_m: Floats = field(default_factory=lambda: np.empty(0))  # (K,) from the face to the last part seen; or 0

    def __post_init__(self) -> None:
        for name in ("speed_mps", "length_m"):
            if len(getattr(self, name)) != len(self.along_m):
                object.__setattr__(self, name, np.zeros(len(self.along_m)))

    def __len__(self) -> int:
        return len(self.along_m)


NOTHING = LaneObstacles(np.empty(0), np.empty(0), np.empty(0))


def locate(road: RoadEdges) -> Lane:
    """Where the vehicle is; the preferred position is the middle of its own lane."""
    lane_m = _bounded(road.lane_m, FAR_M)
    left, right = _bounded(road.left_m, FAR_M) - lane_m, _bounded(road.right_m, FAR_M) - lane_m
    heading, curvature = _bounded(road.heading_rad, TURNED_RAD), _bounded(road.curvature_per_m, SHARPEST_PER_M)
    return Lane(-lane_m, right, left, heading, curvature)


def place(obstacles: Obstacles, lane: Lane) -> LaneObstacles:
    """The bodies on the lane: turned into the road's direction, less the road's bend up to there."""
    if not len(obstacles):
        return NOTHING
    cosine, sine = np.cos(lane.heading_rad), np.sin(lane.heading_rad)
    obstacles = _near(obstacles)
    middle = obstacles.middle_m
    along = cosine * obstacles.forward_m + sine * middle
    across = cosine * middle - sine * obstacles.forward_m
    y = lane.y_m + across - 0.5 * lane.curvature_per_m * along**2
    half = 0.5 * obstacles.width_m
    left, right = y - half, y + half
    part = _parts(along, left, right, obstacles)
    if not part.any():
        return LaneObstacles(along, left, right, obstacles.speed_mps)
    everything = LaneObstacles(along, left, right, obstacles.speed_mps, _lengths(along, part))
    whole: Bools = np.logical_not(part.any(axis=1))
    return everything.chosen(whole)


def _bounded(value: float, most: float) -> float:
    return min(max(value, -most), most)


def _near(obstacles: Obstacles) -> Obstacles:
    """The bodies, none of them farther off or faster than the bounds."""
    places = (obstacles.forward_m, obstacles.left_m, obstacles.right_m)
    if max(np.abs(values).max() for values in places) <= FAR_M and np.abs(obstacles.speed_mps).max() <= FASTEST_MPS:
        return obstacles
    forward, left, right = (np.clip(values, -FAR_M, FAR_M) for values in places)
    speed = np.clip(obstacles.speed_mps, -FASTEST_MPS, FASTEST_MPS)
    return replace(obstacles, forward_m=forward, left_m=left, right_m=right, speed_mps=speed)


def _parts(along_m: Floats, left_m: Floats, right_m: Floats, obstacles: Obstacles) -> Bools:
    """(K, K) which bodies are a part of which: an edge low on its side, or points that fell away from the others.

    Passed as bodies of their own they would keep the car aside for the length of two, and a part of a side that is seen
    at a grazing angle is known worse than the face. What is wider than the body before it is no part of that.
    """
    if len(along_m) < 2:
        return np.zeros((len(along_m), len(along_m)), np.bool_)
    behind, stands = along_m[:, None] - along_m[None], obstacles.speed_mps == 0.0
    near: Bools = (behind > BODY_M[0]) & (behind < BODY_M[1]) & stands & stands[:, None]
    if not near.any():
        return near
    shared = np.minimum(right_m[:, None], right_m[None]) - np.maximum(left_m[:, None], left_m[None])
    width = right_m - left_m
    within = (shared > BODY_SHARE * width[:, None]) & (width[:, None] <= width[None])
    named = (obstacles.identity[:, None] == obstacles.identity[None]) & (shared > 0.0)
    beyond = np.maximum(left_m[None] - left_m[:, None], right_m[:, None] - right_m[None])
    part: Bools = near & (beyond < BODY_BEYOND_M) & (within | named)
    return part


def _lengths(along_m: Floats, part: Bools) -> Floats:
    """(K,) m from each face to the farthest of its parts, and of their parts."""
    for _ in range(PARTS_OF_PARTS):
        part = part | (part @ part)
    behind = np.where(part, along_m[:, None] - along_m[None], 0.0)
    longest: Floats = behind.max(axis=0)
    return longest
