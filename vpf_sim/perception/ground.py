"""The flat road as seen by the moving camera: where a pixel of the road was in an earlier frame."""

import numpy as np

from vpf_sim.geometry import ground_from_pixels, project
from vpf_sim.types import Camera, Floats


def relative_pose(past_pose: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """The vehicle now as seen from the vehicle at each past pose: (N, 2) position in its axes m, (N,) yaw change rad.

    `past_pose` is (N, 3), `pose` (3,), rows (x, y, yaw).
    """
    step = pose[:2] - past_pose[:, :2]
    cosine, sine = np.cos(past_pose[:, 2]), np.sin(past_pose[:, 2])
    position = np.stack([cosine * step[:, 0] + sine * step[:, 1], cosine * step[:, 1] - sine * step[:, 0]], axis=1)
    turn: Floats = np.remainder(pose[2] - past_pose[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    return position, turn


def past_image(camera: Camera, points_m: Floats, past_pose: Floats, pose: Floats) -> Floats:
    """(N, 2) px, where standing points (N, 3) in the axes of the vehicle now were seen from the past poses (N, 3)."""
    position, turn = relative_pose(past_pose, pose)
    cosine, sine = np.cos(turn), np.sin(turn)
    forward = position[:, 0] + cosine * points_m[:, 0] - sine * points_m[:, 1]
    right = position[:, 1] + sine * points_m[:, 0] + cosine * points_m[:, 1]
    return project(camera, np.stack([forward, right, points_m[:, 2]], axis=1))


def ground_flow(camera: Camera, points_px: Floats, past_pose: Floats, pose: Floats) -> Floats:
    """(N, 2) px, the displacement that pixels (N, 2) have if they show the flat road, from the past poses to now.

    Exact for a finite motion in the plane: the pixel is put on the road, seen from the past pose, and the difference
    taken. For a camera that drives straight ahead it is (p - p_FOE) d / (Z + d) with Z = f h / (y - y_h) (METHOD C2).
    Pixels at and above the horizon have no road: there it is the flow of the plane at infinity, the limit from below.
    """
    below = (points_px[:, 1] - camera.cy_px) / camera.fy_px + np.tan(camera.pitch_rad)
    # The road 1 km away stands for infinity; lifting the pixels by a common row keeps the turn's part of the flow.
    nearest_row = camera.cy_px + camera.fy_px * (camera.height_m / 1e3 - np.tan(camera.pitch_rad))
    seen = points_px.copy()
    seen[:, 1] = np.where(below < camera.height_m / 1e3, nearest_row, seen[:, 1])
    road = ground_from_pixels(camera, seen)
    before = past_image(camera, np.column_stack([road, np.zeros(len(road))]), past_pose, pose)
    return seen - before
