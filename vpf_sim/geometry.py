"""Angles, frames and the pinhole camera. Axes as in `vpf_sim.types`."""

from collections.abc import Sequence
from math import cos, pi, sin

import numpy as np

from vpf_sim.types import Camera, Floats

NEWTON_STEPS = 12
LEAST_SLOPE = 0.02  # of the distorted radius: limits the step near the fold of the polynomial


def bounded(value: float, most: float) -> float:
    """The value, or the nearest of -most and most."""
    return min(max(value, -most), most)


def wrap_angle(angle_rad: float) -> float:
    """The angle in [-pi, pi)."""
    return (angle_rad + pi) % (2.0 * pi) - pi


def wrap_angles(angles_rad: Floats) -> Floats:
    """(...) the angles in [-pi, pi)."""
    return np.asarray((angles_rad + pi) % (2.0 * pi) - pi)


def unwrapped(angles: Sequence[float] | Floats, period: float = 2.0 * pi) -> Floats:
    """(N,) the angles without jumps at the period's end, for interpolation, averages and derivatives.

    Each differs from the previous finite one by at most half a period; nan stays nan.
    """
    result = np.array(angles, float)
    finite = np.isfinite(result)
    result[finite] = np.unwrap(result[finite], period=period)  # noqa: TID251
    return result


def rotation(yaw_rad: float) -> Floats:
    """(2, 2) matrix that takes vehicle axes to world axes (paper, section V, transposed)."""
    cosine, sine = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[cosine, -sine], [sine, cosine]])


def distance_m(one: Floats, other: Floats) -> float:
    """Distance, m, between two positions (2,) or poses (3,) in the world."""
    return float(np.hypot(*(one - other)[:2]))


def mounting_in_words(pitch_deg: float, yaw_deg: float) -> str:
    """A camera's mounting as text; pitch is + down, yaw + to the right."""
    vertical, lateral = "down" if pitch_deg >= 0.0 else "up", "right" if yaw_deg >= 0.0 else "left"
    return f"looks {abs(pitch_deg):.2f} deg {vertical} and {abs(yaw_deg):.2f} deg {lateral}"


def vehicle_from_world(points_m: Floats, pose: Floats) -> Floats:
    """(..., 2) world points in the axes of the vehicle at `pose` (x, y, yaw)."""
    relative: Floats = (points_m - pose[:2]) @ rotation(pose[2])
    return relative


def world_from_vehicle(points_m: Floats, pose: Floats) -> Floats:
    """(..., 2) world points of points in the axes of the vehicle at `pose` (x, y, yaw)."""
    absolute: Floats = points_m @ rotation(pose[2]).T + pose[:2]
    return absolute


def horizon_px(camera: Camera) -> float:
    """Image row of the horizon, straight ahead."""
    return float(camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad))


def road_row_px(camera: Camera, depth_m: float) -> float:
    """Image row of the road at a depth, for a camera that looks almost level: tan(pitch) is taken as small."""
    return horizon_px(camera) + camera.fy_px * camera.height_m / depth_m


def straight_ahead_px(camera: Camera) -> Floats:
    """(2,) px, the horizon straight ahead."""
    return np.array([camera.cx_px, horizon_px(camera)])


def project(camera: Camera, points_m: Floats) -> Floats:
    """(..., 2) undistorted px of (..., 3) points in vehicle axes (forward, right, up from the road).

    nan for points at or behind the camera's plane.
    """
    forward, right, up = points_m[..., 0], points_m[..., 1], points_m[..., 2]
    cosine, sine = cos(camera.pitch_rad), sin(camera.pitch_rad)
    ahead, below = forward - camera.forward_m, camera.height_m - up
    depth = cosine * ahead + sine * below
    down = cosine * below - sine * ahead
    pixels = np.full((*depth.shape, 2), np.nan)
    visible = depth > 0.0
    scale = np.divide(1.0, depth, out=pixels[..., 0].copy(), where=visible)
    np.add(camera.cx_px, camera.fx_px * right * scale, out=pixels[..., 0])
    np.add(camera.cy_px, camera.fy_px * down * scale, out=pixels[..., 1])
    return pixels


def normalised(camera: Camera, pixels: Floats) -> tuple[Floats, Floats]:
    """x and y (...,) of undistorted pixels (..., 2) in an image at unit depth: + is right, and down."""
    return (pixels[..., 0] - camera.cx_px) / camera.fx_px, (pixels[..., 1] - camera.cy_px) / camera.fy_px


def ground_from_pixels(camera: Camera, pixels: Floats) -> Floats:
    """(..., 2) m, vehicle axes: flat-road points at undistorted pixels; nan above the horizon."""
    x, y = normalised(camera, pixels)
    cosine, sine = cos(camera.pitch_rad), sin(camera.pitch_rad)
    down = cosine * y + sine
    depth = np.divide(camera.height_m, down, out=np.full(down.shape, np.nan), where=down > 0.0)
    ground = np.empty(pixels.shape)
    np.add(camera.forward_m, depth * (cosine - sine * y), out=ground[..., 0])
    np.multiply(depth, x, out=ground[..., 1])
    return ground


def rotation_flow(camera: Camera, points_px: Floats, yaw_change_rad: Floats) -> Floats:
    """(N, 2) px, flow that the camera's turn to the right alone causes, for points at the END of a window.

    Exact for a finite turn about the vertical axis at pitch 0: each point's ray is rotated back and projected. Subtract
    it from the displacement to derotate the flow.
    """
    x, y = normalised(camera, points_px)
    cosine, sine = np.cos(yaw_change_rad), np.sin(yaw_change_rad)
    depth = cosine - sine * x
    displacement = np.empty(points_px.shape)
    np.multiply(camera.fx_px, x - (sine + cosine * x) / depth, out=displacement[..., 0])
    np.multiply(camera.fy_px, y - y / depth, out=displacement[..., 1])
    return displacement


def distort(camera: Camera, pixels: Floats) -> Floats:
    """(..., 2) distorted px of undistorted pixels, by OpenCV's radial model r -> r (1 + k1 r^2 + k2 r^4)."""
    if camera.k1 == 0.0 and camera.k2 == 0.0:
        return pixels
    ray = (pixels - _centre(camera)) / _focal(camera)
    square = np.sum(ray**2, axis=-1, keepdims=True)
    square = np.minimum(square, 4.0)  # beyond any lens the polynomial may fold back
    distorted: Floats = _centre(camera) + _focal(camera) * ray * (1.0 + camera.k1 * square + camera.k2 * square**2)
    return distorted


def undistort(camera: Camera, pixels: Floats) -> Floats:
    """(..., 2) undistorted px of distorted pixels: inverse of `distort` by Newton's method on the radius."""
    if camera.k1 == 0.0 and camera.k2 == 0.0:
        return pixels
    ray = (pixels - _centre(camera)) / _focal(camera)
    distorted = np.sqrt(np.sum(ray**2, axis=-1, keepdims=True))
    radius = distorted.copy()
    for _ in range(NEWTON_STEPS):
        square = radius**2
        slope = 1.0 + 3.0 * camera.k1 * square + 5.0 * camera.k2 * square**2
        excess = radius * (1.0 + camera.k1 * square + camera.k2 * square**2) - distorted
        radius = np.clip(radius - excess / np.maximum(slope, LEAST_SLOPE), 0.0, 2.0)
    undistorted: Floats = _centre(camera) + _focal(camera) * ray * (radius / np.maximum(distorted, 1e-12))
    return np.where(distorted > 0.0, undistorted, pixels)


def _centre(camera: Camera) -> Floats:
    return np.array([camera.cx_px, camera.cy_px])


def _focal(camera: Camera) -> Floats:
    return np.array([camera.fx_px, camera.fy_px])
