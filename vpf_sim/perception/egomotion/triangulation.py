"""Depth and height of tracked points from their first and latest observation and the vehicle's motion."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.egomotion.ground_plane import relative_pose
from vpf_sim.types import Camera, Floats, Flow


@dataclass(frozen=True, slots=True)
class Triangulation:
    """Points of the flow in space, as if they stood still. chi2 is the track's, by its depth or by the road's."""

    depth_m: Floats  # (N,) along the optical axis from the camera now; nan: unknown
    sigma_m: Floats  # (N,) of depth_m
    height_m: Floats  # (N,) above the road
    height_sigma_m: Floats  # (N,)
    right_m: Floats  # (N,) of the vehicle's axis
    chi2: Floats  # (N,) with the best depth
    chi2_ground: Floats  # (N,) with the flat road's depth; inf above the horizon
    inverse_per_m: Floats  # (N,) fitted for itself: the depth of far points is noise
    inverse_sigma_per_m: Floats  # (N,)


def information(flow: Flow, window_px: int, age_s: Floats, noise: NoiseModel) -> Floats:
    """(N, 2, 2) inverse covariance of a track's displacement, px^-2: cov = sigma^2 S^-1 / n + floor^2 I, times growth.

    Along an edge Lucas-Kanade slides and the small eigenvalue is noise: a share of the large one is subtracted.
    """
    a, b, d = flow.structure[:, 0, 0], flow.structure[:, 0, 1], flow.structure[:, 1, 1]
    mean, half = 0.5 * (a + d), np.hypot(0.5 * (a - d), b)
    large, small = mean + half, mean - half
    trusted = np.maximum(small - noise.anisotropy * large, 1e-3)
    grey = noise.grey_levels**2 / window_px**2
    growth = 1.0 + age_s / noise.growth_s
    large_weight = 1.0 / (growth * (grey / np.maximum(large, 1e-3) + noise.floor_px**2))
    small_weight = 1.0 / (growth * (grey / trusted + noise.floor_px**2))
    # Unit vector of the large eigenvalue by the double angle: cos 2t = (a - d) / (2 half), sin 2t = b / half.
    safe = np.where(half > 1e-9, half, 1.0)
    cosine, sine = np.where(half > 1e-9, 0.5 * (a - d) / safe, 1.0), b / safe
    total, difference = 0.5 * (large_weight + small_weight), 0.5 * (large_weight - small_weight)
    off = difference * sine
    return np.stack([total + difference * cosine, off, off, total - difference * cosine], axis=1).reshape(-1, 2, 2)


def triangulate(flow: Flow, camera: Camera, window_px: int, age_s: Floats, noise: NoiseModel) -> Triangulation:
    """Each point's depth Z by weighted least squares over its first observation; the latest is taken as exact.

    With q the point's ray now and t the camera's way, both in the first camera's axes, the point was at Z q + t. Its
    first image (u, v) gives two linear equations (f q_xy - u q_z) Z = u t_z - f t_xy.
    """
    focal = np.array([camera.fx_px, camera.fy_px])
    centre = np.array([camera.cx_px, camera.cy_px])
    ray = (flow.points_px - centre) / focal
    first = (flow.first_px - centre) / focal
    q, t = _in_first_camera(camera, ray, flow)
    a = focal * (q[:, :2] - first * q[:, 2:])
    b = focal * (first * t[:, 2:] - t[:, :2])
    weight = information(flow, window_px, age_s, noise)
    curvature, mixed, bend = _product(a, weight, a), _product(a, weight, b), _product(b, weight, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(curvature > 1e-12, mixed / curvature, np.nan)
        sigma = np.abs(depth * q[:, 2] + t[:, 2]) / np.sqrt(curvature)
        inverse = np.where(bend > 1e-12, mixed / bend, np.nan)  # of a = b w
        inverse_sigma = np.abs(q[:, 2] + t[:, 2] * inverse) / np.sqrt(bend)

    def chi2(depth_m: Floats) -> tuple[Floats, Floats]:
        """(N,) chi2 at these depths, and (N,) the depths in the first camera."""
        past_depth = depth_m * q[:, 2] + t[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            residual = (a * depth_m[:, None] - b) / past_depth[:, None]
        return _product(residual, weight, residual), past_depth

    cosine, sine = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    down = cosine * ray[:, 1] + sine
    height = camera.height_m - depth * down
    below = down > 1e-4
    ground, past_depth = chi2(camera.height_m / np.where(below, down, 1.0))
    return Triangulation(
        depth_m=depth,
        sigma_m=sigma,
        height_m=height,
        height_sigma_m=np.hypot(sigma * down, depth * noise.pitch_rad),
        right_m=depth * ray[:, 0],
        chi2=chi2(depth)[0],
        chi2_ground=np.where(below & (past_depth > 0.0), ground, np.inf),
        inverse_per_m=inverse,
        inverse_sigma_per_m=inverse_sigma,
    )


def _product(left: Floats, weight: Floats, right: Floats) -> Floats:
    """(N,) left^T weight right of vectors (N, 2) and symmetric matrices (N, 2, 2)."""
    mixed = left[:, 0] * right[:, 1] + left[:, 1] * right[:, 0]
    straight: Floats = weight[:, 0, 0] * left[:, 0] * right[:, 0] + weight[:, 1, 1] * left[:, 1] * right[:, 1]
    return straight + weight[:, 0, 1] * mixed


def _in_first_camera(camera: Camera, ray: Floats, flow: Flow) -> tuple[Floats, Floats]:
    """Rays (N, 3) of the points now and the camera's centre now (N, 3), in the axes of the first camera."""
    position, turn = relative_pose(flow.first_pose, flow.pose)
    cosine, sine = np.cos(turn), np.sin(turn)
    pitch_cosine, pitch_sine = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)

    def to_camera(forward: Floats, right: Floats, down: Floats) -> Floats:
        return np.stack(
            [right, pitch_cosine * down - pitch_sine * forward, pitch_cosine * forward + pitch_sine * down], axis=1
        )

    forward = pitch_cosine - pitch_sine * ray[:, 1]
    down = pitch_sine + pitch_cosine * ray[:, 1]
    turned_forward, turned_right = cosine * forward - sine * ray[:, 0], sine * forward + cosine * ray[:, 0]
    ahead = position[:, 0] + camera.forward_m * (cosine - 1.0)
    aside = position[:, 1] + camera.forward_m * sine
    return to_camera(turned_forward, turned_right, down), to_camera(ahead, aside, np.zeros_like(ahead))
