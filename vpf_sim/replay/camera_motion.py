"""Vehicle path and true focus of expansion from camera poses.

Camera axes are KITTI's and OpenCV's (x right, y down, z forward), ours X forward, Y right. Only this module converts.
"""

from itertools import pairwise

import cv2
import numpy as np

from vpf_sim.geometry import unwrapped
from vpf_sim.types import Camera, Floats

LEAST_MOTION_M = 0.05  # between two frames; below this the direction is noise


def planar(poses: Floats) -> Floats:
    """(N, 3) x, y, yaw in our axes from (N, 3, 4) camera-to-world: X = z, Y = x, yaw from z to x."""
    axis = poses[:, :, 2]  # the optical axis in the world
    yaw = unwrapped(np.arctan2(axis[:, 0], axis[:, 2]))
    return np.stack([poses[:, 2, 3], poses[:, 0, 3], yaw], axis=1)


def directions(poses: Floats) -> Floats:
    """(N - 1, 3) m, camera motion from frame k to k + 1 in the axes halfway between.

    At a steady turn this is also the direction of motion at either frame in its own axes.
    """
    result = []
    for before, after in pairwise(poses):
        moved = before[:, :3].T @ (after[:, 3] - before[:, 3])  # in the axes of k
        turn = before[:, :3].T @ after[:, :3]  # from the axes of k + 1 to those of k
        if not np.isfinite(turn).all():
            result.append(np.full(3, np.nan))
            continue
        half, _ = cv2.Rodrigues(0.5 * cv2.Rodrigues(turn)[0])
        result.append(half.T @ moved)
    return np.array(result)


def expansion(camera: Camera, directions_m: Floats) -> Floats:
    """(N, 2) px, focus of expansion for directions (N, 3) in camera axes.

    It is nan where the camera hardly moved or moved backward.
    """
    right, down, depth = directions_m.T
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = camera.cx_px + camera.fx_px * right / depth, camera.cy_px + camera.fy_px * down / depth
    moved = (np.linalg.norm(directions_m, axis=1) > LEAST_MOTION_M) & (depth > 0.0)
    return np.where(moved[:, None], np.stack([x, y], axis=1), np.nan)


def mounted_pitch(directions_m: Floats) -> float:
    """rad, + down: mean pitch against the direction of travel; 0 for a camera that never moves."""
    total = directions_m[np.linalg.norm(directions_m, axis=1) > LEAST_MOTION_M].sum(axis=0)
    return float(np.arctan2(-total[1], total[2])) if total[2] > 0.0 else 0.0


def extended(poses: Floats, count: int) -> Floats:
    """(count, 3, 4) poses, the last motion continued up to the number of frames."""
    result = list(poses)
    while len(result) < count:
        before, last = (np.vstack([pose, [0.0, 0.0, 0.0, 1.0]]) for pose in result[-2:])
        result.append((last @ np.linalg.inv(before) @ last)[:3])
    return np.array(result)
