"""The points that the flow follows: where they are and have been, since when, and what covers them."""

from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Bools, Floats


@dataclass(slots=True)
class Tracks:
    """What persists of the N points that are followed; rows stay in the order of their identity."""

    trail: Floats  # (G + 1, N, 2) px, newest first
    age: NDArray[np.int64]  # (N,) frames
    identity: NDArray[np.int64]  # (N,) ascending
    first_px: Floats  # (N, 2)
    first_pose: Floats  # (N, 3)
    structure: Floats  # (N, 2, 2)
    next_px: Floats  # (N, 2) the sighting that will replace the first
    next_pose: Floats  # (N, 3)
    next_age: NDArray[np.int64]  # (N,) frames since then
    stuck: Bools  # (N,) as of the last look
    covered: NDArray[np.int64]  # (N,) frames for which something has covered it; 0: it is seen
    held_px: Floats  # (N, 2) where it was before that last began

    @classmethod
    def none(cls, window_frames: int) -> "Tracks":
        """No points; their trails will be of so many frames, and the present one."""
        whole, points, poses = np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 3))
        trail, tensors, flags = np.empty((window_frames + 1, 0, 2)), np.empty((0, 2, 2)), np.empty(0, np.bool_)
        return cls(trail, whole, whole, points, poses, tensors, points, poses, whole, flags, whole, points)

    def __len__(self) -> int:
        return len(self.age)

    def keep(self, chosen: Bools) -> None:
        """Only these (N,)."""
        rows = np.flatnonzero(chosen)
        if len(rows) == len(self):
            return
        # To index arrays of several axes by rows takes five times as long as `take`.
        self.trail = self.trail.take(rows, axis=1)
        self.age, self.identity, self.stuck = self.age[rows], self.identity[rows], self.stuck[rows]
        self.covered, self.held_px = self.covered[rows], self.held_px.take(rows, axis=0)
        self.first_px, self.first_pose = self.first_px.take(rows, axis=0), self.first_pose.take(rows, axis=0)
        self.structure = self.structure.take(rows, axis=0)
        self.next_px, self.next_pose = self.next_px.take(rows, axis=0), self.next_pose.take(rows, axis=0)
        self.next_age = self.next_age[rows]

    def chosen(self, chosen: Bools) -> "Tracks":
        """Some of them."""
        some = copy(self)
        some.keep(chosen)
        return some

    def show(self, rows: NDArray[np.intp], aside_px: Floats) -> None:
        """Points are seen again, so far aside of where they were expected to be now: their trails lead there."""
        frames, steps = self.covered[rows], np.arange(len(self.trail))[:, None]
        share = np.maximum(frames - 1 - steps, 0) / frames
        self.trail[:, rows] += share[..., None] * aside_px
        self.covered[rows] = 0

    def renew_anchor(self, frames: int, pose: Floats) -> None:
        """Where the next sighting is `frames` old, it becomes the first, and the present one the next."""
        due = (self.next_age >= frames) & (self.covered == 0)
        if not due.any():
            return
        column = due[:, None]
        self.first_px = np.where(column, self.next_px, self.first_px)
        self.first_pose = np.where(column, self.next_pose, self.first_pose)
        self.age = np.where(due, self.next_age, self.age)
        self.next_px = np.where(column, self.trail[0], self.next_px)
        self.next_pose = np.where(column, pose, self.next_pose)
        self.next_age = np.where(due, 0, self.next_age)

    def append(self, points_px: Floats, structure: Floats, pose: Floats, next_identity: int) -> None:
        """New ones, first seen now, with the identities from this one on."""
        count = len(points_px)
        self.trail = np.concatenate([self.trail, np.broadcast_to(points_px, (len(self.trail), count, 2))], axis=1)
        self.age = np.concatenate([self.age, np.zeros(count, np.int64)])
        self.identity = np.concatenate([self.identity, np.arange(next_identity, next_identity + count)])
        self.first_px = np.concatenate([self.first_px, points_px])
        self.first_pose = np.concatenate([self.first_pose, np.broadcast_to(pose, (count, 3))])
        self.structure = np.concatenate([self.structure, structure])
        self.next_px = np.concatenate([self.next_px, points_px])
        self.next_pose = np.concatenate([self.next_pose, np.broadcast_to(pose, (count, 3))])
        self.next_age = np.concatenate([self.next_age, np.zeros(count, np.int64)])
        self.stuck = np.concatenate([self.stuck, np.zeros(count, np.bool_)])
        self.covered = np.concatenate([self.covered, np.zeros(count, np.int64)])
        self.held_px = np.concatenate([self.held_px, points_px])
