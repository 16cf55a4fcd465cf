"""What does not move with the scene: spots on the glass before the camera."""

import numpy as np

from vpf_sim.geometry import rotation_flow
from vpf_sim.perception.egomotion.ground_plane import ground_flow
from vpf_sim.types import Bools, Camera, Floats

STILL_PX = 0.6  # a spot on the glass is followed this exactly over its life, plus
STILL_SHARE = 0.05  # this share of the motion that it lacks
LEAST_PX = 4.0  # motion of the scene without which nothing can be told
ABOVE_SHARE = 0.3  # of the road's motion, that scenery has as far above the horizon as the road lies below it


def scene_motion(camera: Camera, points_px: Floats, past_pose: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """(N, 2) px each, how the car's way and its turn since the past poses (N, 3) have moved what stands far off.

    What is seen below the horizon is no farther than the road there, which the way moves so; what is nearer moves by a
    multiple of it. Above the horizon scenery is taken to be nearer than three times the road that is seen as far below.
    The turn moves everything alike.
    """
    turn = pose[2] - past_pose[:, 2]
    horizon = camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad)
    above = points_px[:, 1] < horizon
    mirrored = points_px.copy()
    mirrored[above, 1] = 2.0 * horizon - points_px[above, 1]
    by_way = ground_flow(camera, mirrored, past_pose, pose) - rotation_flow(camera, mirrored, turn)
    by_way[above] *= [ABOVE_SHARE, -ABOVE_SHARE]
    return by_way, rotation_flow(camera, points_px, turn)


def least_motion(by_way_px: Floats, by_turn_px: Floats) -> Floats:
    """(N,) px, how far scenery must have moved at least: there may be a nearness at which way and turn make up."""
    square = np.sum(by_way_px**2, axis=1) + 1e-12
    times = np.maximum(1.0, -np.sum(by_way_px * by_turn_px, axis=1) / square)
    motion = by_turn_px + times[:, None] * by_way_px
    least: Floats = np.hypot(motion[:, 0], motion[:, 1])
    return least


def stuck(camera: Camera, points_px: Floats, first_px: Floats, first_pose: Floats, pose: Floats) -> Bools:
    """(N,) points that stayed where they were first seen (N, 2), though the car has moved on since (N, 3).

    Drops, dirt and the hood's mirror image in the glass do so, for they ride along. So does a body that drives ahead
    at the car's own speed: no flow tells the two apart.
    """
    expected = least_motion(*scene_motion(camera, points_px, first_pose, pose))
    moved = np.hypot(points_px[:, 0] - first_px[:, 0], points_px[:, 1] - first_px[:, 1])
    still: Bools = (expected > LEAST_PX) & (moved < STILL_PX + STILL_SHARE * expected)
    return still
