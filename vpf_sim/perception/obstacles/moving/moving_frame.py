"""Point tracks in the frame of a vehicle that moves along the road."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.geometry import normalised
from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.egomotion.ground_plane import past_image
from vpf_sim.perception.egomotion.triangulation import information
from vpf_sim.types import Camera, Floats, Flow

STEP_MPS = 0.1  # of the numerical derivatives
STEP_RATIO = 0.02


@dataclass(frozen=True, slots=True)
class Course:
    """Speed of a vehicle, with the road's direction in the world and curvature at its place."""

    speed_mps: float
    direction_rad: float
    curvature_per_m: float

    def way(self, time_s: Floats, speed_mps: Floats, turn_rad: Floats) -> Floats:
        """(V, M, 2) m driven in the last seconds (M,), along the arc's chord, at speeds and turned by angles (V, 1)."""
        way = speed_mps * time_s
        angle = self.direction_rad + turn_rad - 0.5 * self.curvature_per_m * way
        return np.stack([way * np.cos(angle), way * np.sin(angle)], axis=-1)


@dataclass(frozen=True, slots=True)
class Residuals:
    """Residuals of M point tracks against a vehicle's course, at their first observations, and derivatives."""

    residual_px: Floats  # (M, 2) observed less expected
    by_depth: Floats  # (M, 2) px / m
    by_speed: Floats  # (M, 2) px / (m/s)
    by_turn: Floats  # (M, 2) px / rad, of the course
    weight: Floats  # (M, 2, 2) inverse covariance of an observation, px^-2


def rays(camera: Camera, points_px: Floats) -> Floats:
    """(M, 3) forward, right, down of pixels (M, 2) at unit depth, in the axes of the vehicle."""
    x, y = normalised(camera, points_px)
    cosine, sine = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    return np.stack([cosine - sine * y, x, sine + cosine * y], axis=1)


def against(
    flow: Flow, camera: Camera, course: Course, depth_m: Floats, rate_hz: float, window_px: int, noise: NoiseModel
) -> Residuals:
    """Residuals of the point tracks of `flow` against a vehicle on `course` with each at `depth_m` (M,) now.

    In the frame of the vehicle only the camera moves: each point is projected into the camera of its first observation,
    moved on by the vehicle's way since. A point that would have been behind that camera gets a large residual.
    """
    ray, age_s = rays(camera, flow.points_px), flow.age_frames / rate_hz
    farther, faster, turned = np.eye(4)[1:, :, None]  # the second to fourth projections take one step each
    depth = depth_m * (1.0 + STEP_RATIO * farther)
    place = ray * depth[..., None] * [1.0, 1.0, -1.0] + [camera.forward_m, 0.0, camera.height_m]
    past_pose = np.tile(flow.first_pose, (len(depth), 1, 1))
    past_pose[..., :2] += course.way(age_s, course.speed_mps + STEP_MPS * faster, STEP_RATIO * turned)
    with np.errstate(divide="ignore", invalid="ignore"):
        seen = past_image(camera, place.reshape(-1, 3), past_pose.reshape(-1, 3), flow.pose)
    expected, at_depth, at_speed, at_turn = seen.reshape(len(depth), -1, 2)
    by_depth = (at_depth - expected) / (STEP_RATIO * depth_m)[:, None]
    by_speed = (at_speed - expected) / STEP_MPS
    by_turn = (at_turn - expected) / STEP_RATIO
    weight = information(flow, window_px, age_s, noise)
    residual = flow.first_px - expected
    never = np.isnan(residual + by_depth + by_speed + by_turn).any(axis=1)
    residual[never] = 1e3
    for slope in (by_depth, by_speed, by_turn):
        slope[never] = 0.0
    return Residuals(residual, by_depth, by_speed, by_turn, weight)
