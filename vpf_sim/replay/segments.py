"""Segments of a recording: start of the model vehicle and goal of each.

As in the paper, the goal is the last pose of the segment, and the speed to keep is the recorded one at its start.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import cos, sin

import numpy as np

from vpf_sim.replay.recording import Recording
from vpf_sim.types import Floats

LONGEST_S = 20.0
AHEAD_M = 100.0  # to the goal on the current course, without poses
BEYOND_M = 40.0  # of route past the last pose
GOAL_POSE = "the last pose of each segment"
GOAL_AHEAD = f"{AHEAD_M:g} m ahead on the course at the start of each segment"


@dataclass(frozen=True, slots=True)
class Segment:
    """The frames `first` <= k < `stop`."""

    first: int
    stop: int
    goal_m: tuple[float, float]
    speed_mps: float


def segments(recording: Recording) -> list[Segment]:
    """Equal parts of at most LONGEST_S; a part also ends where an obstacle label changes."""
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
    """Whether the poses are recorded or derived."""
    return recording.origins["poses"].is_known


def goal_text(recording: Recording) -> str:
    """What the goals are, for the table."""
    return GOAL_POSE if has_poses(recording) else GOAL_AHEAD


def route(poses: Floats) -> Floats:
    """(M, 2) m, points 1 m apart along the driven path and straight on."""
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
    """m/s; 0 for a car that rolls back."""
    return max(float(recording.speed_mps[first]), 0.0)
