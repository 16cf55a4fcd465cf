"""Vehicle paths in our axes, X forward and Y right: by latitude and longitude, and by the poses of a camera.

Camera axes are KITTI's and OpenCV's (x right, y down, z forward). Poses of a camera also give the true focus of
expansion.
"""

from itertools import pairwise

import cv2
import numpy as np

from vpf_sim.geometry import unwrapped
from vpf_sim.replay import derived, series
from vpf_sim.replay.plausible import Location, reachable, within_limits
from vpf_sim.types import Camera, Floats

EARTH_RADIUS_M = 6378137.0
COURSE_WINDOW_S = 1.0  # for the direction of travel
LEAST_SPEED_MPS = 1.0  # below this the course is held: a standing receiver drifts
LEAST_MOTION_M = 0.05  # between two frames; below this the direction is noise


def fixes(times_s: Floats, latitude_deg: Floats, longitude_deg: Floats, where: Location, notes: list[str]) -> Floats:
    """(N, 2) m from the first fix, north and east; nan without a fix and at impossible positions."""
    latitude_deg = within_limits(latitude_deg, "latitude_deg", where, notes)
    longitude_deg = within_limits(longitude_deg, "longitude_deg", where, notes)
    none = (latitude_deg == 0.0) & (longitude_deg == 0.0)
    if none.any():
        notes.append(f"{where}: {np.count_nonzero(none)} of {len(none)} positions removed: 0, 0 is no fix")
    latitude, longitude = (np.where(none, np.nan, degrees) for degrees in (latitude_deg, longitude_deg))
    return reachable(times_s, north_east(latitude, longitude), where, notes)


def north_east(latitude_deg: Floats, longitude_deg: Floats) -> Floats:
    """(N, 2) m from the first known position, by Mercator's projection; nan where unknown."""
    longitude = unwrapped(longitude_deg, 360.0)
    known = np.isfinite(latitude_deg) & np.isfinite(longitude)
    first = int(np.argmax(known))
    scale = np.cos(np.radians(latitude_deg[first])) * EARTH_RADIUS_M
    north = scale * np.log(np.tan(np.pi / 4.0 + 0.5 * np.radians(latitude_deg)))
    east = scale * np.radians(longitude)
    return np.where(known[:, None], np.stack([north - north[first], east - east[first]], axis=1), np.nan)


def poses(north_east_m: Floats, heading_rad: Floats) -> Floats:
    """(N, 3) poses from the first known position and heading; headings clockwise from north."""
    heading = unwrapped(heading_rad)
    first = int(np.argmax(np.isfinite(north_east_m).all(axis=1) & np.isfinite(heading)))
    cosine, sine = np.cos(heading[first]), np.sin(heading[first])
    north, east = (north_east_m - north_east_m[first]).T
    return np.stack([cosine * north + sine * east, cosine * east - sine * north, heading - heading[first]], axis=1)


def course(times_s: Floats, north_east_m: Floats) -> Floats:
    """(N,) rad clockwise from north, direction of travel; held while the vehicle is stationary."""
    flat = [series.filled(times_s, part)[0] for part in north_east_m.T]
    if len(times_s) < 2 or not np.isfinite(flat).all():
        return np.zeros(len(times_s))
    north, east = (derived.slope(times_s, part, COURSE_WINDOW_S) for part in flat)
    moving = np.hypot(north, east) > LEAST_SPEED_MPS
    if not moving.any():
        return np.zeros(len(times_s))
    last = np.maximum.accumulate(np.where(moving, np.arange(len(times_s)), np.argmax(moving)))
    return unwrapped(np.arctan2(east, north)[last])


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
