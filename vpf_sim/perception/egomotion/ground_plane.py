"""Image motion of the flat road under the moving camera."""

from math import tan

import numpy as np

from vpf_sim.geometry import ground_from_pixels, project
from vpf_sim.types import Camera, Floats


def relative_pose(past_pose: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """(N, 2) m, the position of `pose` (3,) in the axes of each past pose (N, 3), and (N,) rad, the yaw change."""
    x, y = pose[0] - past_pose[:, 0], pose[1] - past_pose[:, 1]
    cosine, sine = np.cos(past_pose[:, 2]), np.sin(past_pose[:, 2])
    position = np.empty((len(past_pose), 2))
    np.add(cosine * x, sine * y, out=position[:, 0])
    np.subtract(cosine * y, sine * x, out=position[:, 1])
    turn: Floats = np.remainder(pose[2] - past_pose[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    return position, turn


def past_image(camera: Camera, points_m: Floats, past_pose: Floats, pose: Floats) -> Floats:
    """(N, 2) px, images of standing points (N, 3), vehicle axes now, from the past poses (N, 3)."""
    position, turn = relative_pose(past_pose, pose)
    cosine, sine = np.cos(turn), np.sin(turn)
    past = np.empty(points_m.shape)
    np.subtract(position[:, 0] + cosine * points_m[:, 0], sine * points_m[:, 1], out=past[:, 0])
    np.add(position[:, 1] + sine * points_m[:, 0], cosine * points_m[:, 1], out=past[:, 1])
    past[:, 2] = points_m[:, 2]
    return project(camera, past)


def ground_flow(camera: Camera, points_px: Floats, past_pose: Floats, pose: Floats) -> Floats:
    """(N, 2) px, displacement of pixels (N, 2) of the flat road from the past poses to now.

    Exact for any motion in the plane. Straight ahead it is (p - p_FOE) d / (Z + d) with Z = f h / (y - y_h). At and
    above the horizon it is the flow of the plane at infinity.
    """
    below = below_horizon(camera, points_px)
    # The road 1 km away stands for infinity.
    nearest_row = camera.cy_px + camera.fy_px * (camera.height_m / 1e3 - tan(camera.pitch_rad))
    seen = points_px.copy()
    seen[below < camera.height_m / 1e3, 1] = nearest_row
    road = np.zeros((len(seen), 3))
    road[:, :2] = ground_from_pixels(camera, seen)
    return seen - past_image(camera, road, past_pose, pose)


def below_horizon(camera: Camera, points_px: Floats) -> Floats:
    """(N,) tangents of pixels (N, 2) below the horizon: 1/m, the inverse depth of a road 1 m below the camera."""
    below: Floats = (points_px[:, 1] - camera.cy_px) / camera.fy_px + np.tan(camera.pitch_rad)
    return below
