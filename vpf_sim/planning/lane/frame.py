"""Lane coordinates, in which the lane planner works.

`along` is measured from the pose along the road, `y` across it, from the middle of the own lane, + is right. The
camera's road edges give the transformation; no map is used.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from vpf_sim.planning.lane.lane_settings import PartsConfig
from vpf_sim.types import Bools, Floats, LateralExtents, Obstacles, RoadEdges

PART_DOUBLINGS = 2  # a truck's side is detected in up to four parts
# Bounds of lane coordinates, far beyond any road: sums and squares of them stay finite.
FAR_M, SHARPEST_PER_M, TURNED_RAD, FASTEST_MPS = 1e4, 1.0, 4.0, 1e3


@dataclass(frozen=True, slots=True)
class Lane:
    """Pose of the vehicle on the road, as the camera sees it."""

    y_m: float  # of the pose
    right_m: float  # y of the right edge
    left_m: float  # y of the left edge
    heading_rad: float  # direction of the road minus yaw
    curvature_per_m: float  # of the road at the pose, + bends right


@dataclass(frozen=True, slots=True)
class LaneObstacles(LateralExtents):
    """K obstacles in lane coordinates."""

    along_m: Floats  # (K,) nearest face, from the pose
    left_m: Floats  # (K,) y of the left side
    right_m: Floats  # (K,) y of the right side
    speed_mps: Floats = field(default_factory=lambda: np.empty(0))  # (K,) along the road; left out, all are static
    length_m: Floats = field(default_factory=lambda: np.empty(0))  # (K,) from the face to the last part seen, or 0

    def __post_init__(self) -> None:
        for name in ("speed_mps", "length_m"):
            if len(getattr(self, name)) != len(self.along_m):
                object.__setattr__(self, name, np.zeros(len(self.along_m)))

    def __len__(self) -> int:
        return len(self.along_m)


NOTHING = LaneObstacles(np.empty(0), np.empty(0), np.empty(0))


def locate(road: RoadEdges) -> Lane:
    """Pose on the road; the preferred position is the middle of the own lane."""
    lane_m = _bounded(road.lane_m, FAR_M)
    left, right = _bounded(road.left_m, FAR_M) - lane_m, _bounded(road.right_m, FAR_M) - lane_m
    heading, curvature = _bounded(road.heading_rad, TURNED_RAD), _bounded(road.curvature_per_m, SHARPEST_PER_M)
    return Lane(-lane_m, right, left, heading, curvature)


def place(obstacles: Obstacles, lane: Lane, parts: PartsConfig | None) -> LaneObstacles:
    """The obstacles in lane coordinates, with those merged that are `parts` of another one."""
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
    part = None if parts is None else _parts(along, left, right, obstacles, parts)
    if part is None or not part.any():
        return LaneObstacles(along, left, right, obstacles.speed_mps)
    everything = LaneObstacles(along, left, right, obstacles.speed_mps, _lengths(along, part))
    whole: Bools = np.logical_not(part.any(axis=1))
    return everything.select(whole)


def _bounded(value: float, most: float) -> float:
    return min(max(value, -most), most)


def _near(obstacles: Obstacles) -> Obstacles:
    """The obstacles, with position and speed within the bounds."""
    places = (obstacles.forward_m, obstacles.left_m, obstacles.right_m)
    if max(np.abs(values).max() for values in places) <= FAR_M and np.abs(obstacles.speed_mps).max() <= FASTEST_MPS:
        return obstacles
    forward, left, right = (np.clip(values, -FAR_M, FAR_M) for values in places)
    speed = np.clip(obstacles.speed_mps, -FASTEST_MPS, FASTEST_MPS)
    return replace(obstacles, forward_m=forward, left_m=left, right_m=right, speed_mps=speed)


def _parts(along_m: Floats, left_m: Floats, right_m: Floats, obstacles: Obstacles, parts: PartsConfig) -> Bools:
    """(K, K) which obstacles are a part of which: an edge of its side, or a fragment.

    As obstacles of their own they would keep the car aside for the length of two. A wider obstacle is no part of the
    one before it.
    """
    if len(along_m) < 2:
        return np.zeros((len(along_m), len(along_m)), np.bool_)
    behind, static = along_m[:, None] - along_m[None], obstacles.speed_mps == 0.0
    near: Bools = (behind > parts.least_behind_m) & (behind < parts.most_behind_m) & static & static[:, None]
    if not near.any():
        return near
    shared = np.minimum(right_m[:, None], right_m[None]) - np.maximum(left_m[:, None], left_m[None])
    width = right_m - left_m
    within = (shared > parts.share * width[:, None]) & (width[:, None] <= width[None])
    named = (obstacles.identity[:, None] == obstacles.identity[None]) & (shared > 0.0)
    beyond = np.maximum(left_m[None] - left_m[:, None], right_m[:, None] - right_m[None])
    part: Bools = near & (beyond < parts.beyond_m) & (within | named)
    return part


def _lengths(along_m: Floats, part: Bools) -> Floats:
    """(K,) m from each face to the farthest of its parts, directly or through other parts."""
    for _ in range(PART_DOUBLINGS):
        part = part | (part @ part)
    behind = np.where(part, along_m[:, None] - along_m[None], 0.0)
    longest: Floats = behind.max(axis=0)
    return longest
