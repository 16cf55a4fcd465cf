"""Points on the windscreen: drops and dirt, which do not move with the scene."""

import numpy as np

from vpf_sim.geometry import horizon_px, rotation_flow
from vpf_sim.perception.egomotion.egomotion_settings import WindscreenPointConfig
from vpf_sim.perception.egomotion.ground_plane import ground_flow
from vpf_sim.types import Bools, Camera, Floats

ABOVE_SHARE = 0.3  # motion of scenery above the horizon over the road's motion as far below it


def scene_motion(camera: Camera, points_px: Floats, past_pose: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """(N, 2) px each, the scene's image motion by translation and by rotation since the past poses (N, 3).

    Below the horizon the translation is that of the road, the farthest surface there; nearer points move by a multiple.
    Above the horizon it is ABOVE_SHARE of the mirrored point's. The rotation does not depend on distance.
    """
    turn = pose[2] - past_pose[:, 2]
    horizon = horizon_px(camera)
    above = points_px[:, 1] < horizon
    mirrored = points_px.copy()
    mirrored[above, 1] = 2.0 * horizon - points_px[above, 1]
    by_way = ground_flow(camera, mirrored, past_pose, pose) - rotation_flow(camera, mirrored, turn)
    by_way[above] *= [ABOVE_SHARE, -ABOVE_SHARE]
    return by_way, rotation_flow(camera, points_px, turn)


def least_motion(by_way_px: Floats, by_turn_px: Floats) -> Floats:
    """(N,) px, least image motion of scenery over all distances: translation and rotation may cancel."""
    square = np.sum(by_way_px**2, axis=1) + 1e-12
    times = np.maximum(1.0, -np.sum(by_way_px * by_turn_px, axis=1) / square)
    motion = by_turn_px + times[:, None] * by_way_px
    least: Floats = np.hypot(motion[:, 0], motion[:, 1])
    return least


def on_glass(
    camera: Camera,
    points_px: Floats,
    first_px: Floats,
    first_pose: Floats,
    pose: Floats,
    config: WindscreenPointConfig,
) -> Bools:
    """(N,) points that stayed at their first observation (N, 2) while the vehicle moved since its pose then (N, 3).

    Flow cannot separate drops and dirt from a vehicle that drives ahead at the same speed.
    """
    expected = least_motion(*scene_motion(camera, points_px, first_pose, pose))
    moved = np.hypot(points_px[:, 0] - first_px[:, 0], points_px[:, 1] - first_px[:, 1])
    still: Bools = (expected > config.least_px) & (moved < config.still_px + config.still_share * expected)
    return still
