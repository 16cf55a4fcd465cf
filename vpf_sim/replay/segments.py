"""The segments of a recording: where the model vehicle begins anew, and where each is bound for.

As in the paper, the goal of a segment is its last pose and the speed to keep is the recorded speed at its start.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import cos, sin

import numpy as np

from vpf_sim.replay.recording import Recording
from vpf_sim.types import Floats

LONGEST_S = 20.0
AHEAD_M = 100.0  # of the goal, on the present course, where no poses are known
BEYOND_M = 40.0  # of route behind the last pose
GOAL_POSE = "the last pose of each segment"
GOAL_AHEAD = f"{AHEAD_M:g} m ahead on the present course at the start of each segment"


@dataclass(frozen=True, slots=True)
class Segment:
    """The frames `first` <= k < `stop`."""

    first: int
    stop: int
    goal_m: tuple[float, float]
    speed_mps: float


def segments(recording: Recording) -> list[Segment]:
    """Equal parts of at most LONGEST_S; where a label says that obstacles begin or end, a part ends too."""
    labels = recording.obstacle
    same = (labels[1:] == labels[:-1]) | (np.isnan(labels[1:]) & np.isnan(labels[:-1]))
    changes = [0, *(np.flatnonzero(~same) + 1).tolist(), len(recording)]
    found = []
    for first, stop in pairwise(changes):
        duration = recording.times_s[stop - 1] - recording.times_s[first]
        count = max(1, int(np.ceil(duration / LONGEST_S)))
        found += [(int(part[0]), int(part[-1]) + 1) for part in np.array_split(np.arange(first, stop), count)]
    return [Segment(first, stop, _goal(recording, first, stop), _speed(recording, first)) for first, stop in found]


def has_poses(recording: Recording) -> bool:
    """Whether the recording says where it went, be it by way of speed and yaw rate."""
    return recording.origins["poses"].is_known


def goal_words(recording: Recording) -> str:
    """What the goals are, for the table."""
    return GOAL_POSE if has_poses(recording) else GOAL_AHEAD


def route(poses: Floats) -> Floats:
    """(M, 2) m, 1 m apart, along the way that was driven and straight on."""
    heading = poses[-1, 2]
    beyond = poses[-1, :2] + BEYOND_M * np.array([np.cos(heading), np.sin(heading)])
    points = np.vstack([poses[:, :2], beyond])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    stations = np.arange(0.0, along[-1], 1.0)
    return np.stack([np.interp(stations, along, points[:, i]) for i in range(2)], axis=1)


def _goal(recording: Recording, first: int, stop: int) -> tuple[float, float]:
    x, y, yaw = (float(value) for value in recording.poses[first])
    if has_poses(recording):
        return float(recording.poses[stop - 1, 0]), float(recording.poses[stop - 1, 1])
    return x + AHEAD_M * cos(yaw), y + AHEAD_M * sin(yaw)


def _speed(recording: Recording, first: int) -> float:
    """m/s; a car that rolls back is to stand."""
    return max(float(recording.speed_mps[first]), 0.0)
