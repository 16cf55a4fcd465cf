"""Tracked points: where they are and were, since when, and whether something covers them."""

from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Bools, Floats


@dataclass(slots=True)
class Tracks:
    """The N tracked points; rows stay in the order of their identity."""

    trail: Floats  # (G + 1, N, 2) px, newest first
    age: NDArray[np.int64]  # (N,) frames
    identity: NDArray[np.int64]  # (N,) ascending
    first_px: Floats  # (N, 2)
    first_pose: Floats  # (N, 3)
    structure: Floats  # (N, 2, 2)
    next_px: Floats  # (N, 2) the observation that will replace the first
    next_pose: Floats  # (N, 3)
    next_age: NDArray[np.int64]  # (N,) frames since then
    on_glass: Bools  # (N,) on the windscreen
    occluded: NDArray[np.int64]  # (N,) frames for which it has been occluded; 0: visible
    held_px: Floats  # (N, 2) where it was before it was last occluded

    @classmethod
    def none(cls, window_frames: int) -> "Tracks":
        """No points; their trails will have `window_frames` frames and the present one."""
        whole, points, poses = np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 3))
        trail, tensors, flags = np.empty((window_frames + 1, 0, 2)), np.empty((0, 2, 2)), np.empty(0, np.bool_)
        return cls(trail, whole, whole, points, poses, tensors, points, poses, whole, flags, whole, points)

    def __len__(self) -> int:
        return len(self.age)

    def keep(self, chosen: Bools) -> None:
        """Keep these (N,) alone."""
        rows = np.flatnonzero(chosen)
        if len(rows) == len(self):
            return
        for name in self.__slots__:  # `take` is five times as fast as an index
            setattr(self, name, getattr(self, name).take(rows, axis=1 if name == "trail" else 0))

    def select(self, chosen: Bools) -> "Tracks":
        """Some of the points."""
        some = copy(self)
        some.keep(chosen)
        return some

    def uncover(self, rows: NDArray[np.intp], aside_px: Floats) -> None:
        """Points are found again, `aside_px` (n, 2) from the prediction: bend their trails to there."""
        frames, steps = self.occluded[rows], np.arange(len(self.trail))[:, None]
        share = np.maximum(frames - 1 - steps, 0) / frames
        self.trail[:, rows] += share[..., None] * aside_px
        self.occluded[rows] = 0

    def renew_first(self, frames: int, pose: Floats) -> None:
        """Where the next observation is `frames` old, it becomes the first, and the present one the next."""
        due = (self.next_age >= frames) & (self.occluded == 0)
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
        """Add points that are first observed now, with identities from `next_identity` on."""
        count = len(points_px)
        whole, poses = np.zeros(count, np.int64), np.broadcast_to(pose, (count, 3))
        trail = np.broadcast_to(points_px, (len(self.trail), count, 2))
        identity = np.arange(next_identity, next_identity + count)
        flags = np.zeros(count, np.bool_)
        new = Tracks(
            trail, whole, identity, points_px, poses, structure, points_px, poses, whole, flags, whole, points_px
        )
        for name in self.__slots__:
            parts = [getattr(self, name), getattr(new, name)]
            setattr(self, name, np.concatenate(parts, axis=1 if name == "trail" else 0))
