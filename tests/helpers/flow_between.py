"""The flow of points between two moments."""

import numpy as np
from numpy.typing import ArrayLike

from vpf_sim.types import Floats, Flow

ORIGIN = np.zeros(3)


def flow_between(
    now_px: Floats,
    past_px: Floats,
    past_pose: ArrayLike = ORIGIN,
    pose: ArrayLike = ORIGIN,
    gap_s: float = 0.1,
    age_frames: int = 6,
    structure: float = 1.0,
) -> Flow:
    """Of points (N, 2), numbered from 0, which were first seen at the past pose; corners with that eigenvalue."""
    count = len(now_px)
    poses = np.tile(np.asarray(past_pose, float), (count, 1))
    return Flow(
        points_px=now_px,
        displacement_px=now_px - past_px,
        gap_s=np.full(count, gap_s),
        past_pose=poses,
        pose=np.asarray(pose, float),
        identity=np.arange(count),
        first_px=past_px,
        first_pose=poses,
        age_frames=np.full(count, age_frames),
        structure=np.tile(structure * np.eye(2), (count, 1, 1)),
    )
