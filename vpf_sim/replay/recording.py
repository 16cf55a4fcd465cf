"""A recorded drive, whatever format it came in: frames, times, camera, motion, and what is known of the truth."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from vpf_sim.types import Camera, Floats, Image


@dataclass(frozen=True, slots=True)
class Recording:
    """N frames and what was recorded with them. The pose is the camera's place in vehicle axes (X forward, Y right)."""

    name: str
    camera: Camera
    times_s: Floats  # (N,) ascending
    poses: Floats  # (N, 3) x m, y m, yaw rad; yaw is the direction of the optical axis
    speed_mps: Floats  # (N,)
    yaw_rate_radps: Floats  # (N,) + turns right
    foe_px: Floats  # (N, 2) truth of the motion from the frame before, in the axes half way between; nan where unknown
    derived: tuple[str, ...]  # which of these were not recorded but computed, and from what
    frames: Callable[[], Iterator[Image]]  # (H, W, 3) RGB each, from the first

    def __len__(self) -> int:
        return len(self.times_s)

    @property
    def rate_hz(self) -> float:
        """Frames a second, by the median of the intervals."""
        return 1.0 / float(np.median(np.diff(self.times_s)))
