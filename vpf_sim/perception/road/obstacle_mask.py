"""The part of a bird's-eye patch that obstacles hide from the camera."""

import numpy as np

from vpf_sim.perception.object_sizes import lengths_m
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.model import rows_seen
from vpf_sim.perception.road.road_settings import ObstacleMaskConfig
from vpf_sim.types import Bools, Obstacles


def hidden_by(obstacles: Obstacles, view: BirdsEye, pitch_rad: float, config: ObstacleMaskConfig) -> Bools:
    """(rows, columns) whether an obstacle's face or flank hides each place of the patch."""
    hidden = np.zeros(view.visible.shape, np.bool_)
    forward_m, nearest_m = view.camera.forward_m, config.nearest_m
    seen_m, _ = rows_seen(pitch_rad, view.forward_m, view.camera)
    ahead = (view.forward_m - forward_m)[:, None]
    bearing = view.right_m / ahead
    sides = zip(obstacles.forward_m, obstacles.left_m, obstacles.right_m, strict=True)
    for (face, left, right), length in zip(sides, lengths_m(obstacles.width_m), strict=True):
        depth = float(face) - forward_m
        beside = left > 0.0 or right < 0.0
        if depth + beside * length < nearest_m:  # behind the camera, where a passed object is still predicted
            continue
        rows = seen_m > face - config.margin_m
        # Where the line of sight passes the face, and the far end of the visible flank.
        at_face = bearing[rows] * max(depth, nearest_m)
        at_end = bearing[rows] * np.minimum(ahead[rows], depth + length)
        left_of = (at_end if left > 0.0 else at_face) > left - config.margin_m
        hidden[rows] |= left_of & ((at_end if right < 0.0 else at_face) < right + config.margin_m)
    return hidden
