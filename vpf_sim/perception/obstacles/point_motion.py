"""How the image points of a frame moved, linear in their inverse depth and the velocity of what they are on."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vpf_sim.geometry import normalised
from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.egomotion.ground_plane import relative_pose
from vpf_sim.perception.egomotion.triangulation import information
from vpf_sim.perception.obstacles.moving.moving_frame import rays
from vpf_sim.types import Camera, Floats, Flow, Rows

NEAREST_PER_M = 0.5
CHI2_SCALE = 9.0  # of a point that counts half


class Fit(NamedTuple):
    """What points have in common."""

    solved: Floats  # (k,)
    sigma: Floats  # (k,) standard deviations
    chi2: Floats  # (N,) of the points


@dataclass(frozen=True, slots=True)
class PointMotions(Rows):
    """Motions of N points over the flow's windows.

    residual px = by_depth w + by_across (u w) + by_along (v w) - far, for an inverse depth w, 1/m, and velocities u to
    the right and v forward, m/s, in vehicle axes.
    """

    drop: Floats  # (N,) slope of the ray downwards
    bearing: Floats  # (N,) and to the right
    by_depth: Floats  # (N, 2)
    by_across: Floats  # (N, 2)
    by_along: Floats  # (N, 2)
    far: Floats  # (N, 2)
    weight: Floats  # (N, 2, 2)

    def chi2(self, residual: Floats) -> Floats:
        """(N,) of residuals (N, 2)."""
        return np.asarray(np.einsum("ni,nij,nj->n", residual, self.weight, residual))

    def fit(self, slope: Floats, mean: Floats, sigma: Floats, passes: int) -> Fit:
        """The k unknowns that `slope` (N, 2, k) multiplies, by reweighted least squares (Cauchy).

        `mean` and `sigma` (k,) are their prior.
        """
        gain, prior = slope.transpose(0, 2, 1) @ self.weight, np.diag(sigma**-2)
        trust = np.ones(len(slope))
        for _ in range(passes):
            normal = prior + np.einsum("n,nij,njk->ik", trust, gain, slope)
            solved = np.linalg.solve(normal, prior @ mean + np.einsum("n,nij,nj->i", trust, gain, self.far))
            chi2 = self.chi2(slope @ solved - self.far)
            trust = 1.0 / (1.0 + chi2 / CHI2_SCALE)
        return Fit(solved, np.sqrt(np.diagonal(np.linalg.inv(normal))), chi2)

    def static_chi2(self, least_per_m: Floats) -> Floats:
        """(N,) of points that stand, with the best inverse depth from `least_per_m` (N,) on."""
        weighted = np.einsum("nij,nj->ni", self.weight, self.by_depth)
        curvature = np.maximum((weighted * self.by_depth).sum(axis=1), 1e-12)
        inverse = np.clip((weighted * self.far).sum(axis=1) / curvature, least_per_m, NEAREST_PER_M)
        return self.chi2(self.by_depth * inverse[:, None] - self.far)


def point_motions(flow: Flow, camera: Camera, window_px: int, noise: NoiseModel) -> PointMotions:
    """The motions over the flow's windows; a past ray is f - f_w w - f_u u w - f_v v w forward, and so on."""
    ray, past = rays(camera, flow.points_px), flow.points_px - flow.displacement_px
    x, y = normalised(camera, past)
    position, turn = relative_pose(flow.past_pose, flow.pose)
    cosine, sine = np.cos(turn), np.sin(turn)
    zero = np.zeros_like(x)
    forward = np.stack(
        [
            cosine * ray[:, 0] - sine * ray[:, 1],
            position[:, 0] + (cosine - 1.0) * camera.forward_m,
            sine * flow.gap_s,
            -cosine * flow.gap_s,
        ]
    )
    right = np.stack(
        [
            sine * ray[:, 0] + cosine * ray[:, 1],
            position[:, 1] + sine * camera.forward_m,
            -cosine * flow.gap_s,
            -sine * flow.gap_s,
        ]
    )
    down = np.stack([ray[:, 2], zero, zero, zero])
    pitch_cosine, pitch_sine = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    depth = pitch_cosine * forward + pitch_sine * down  # along the past camera's axis
    below = pitch_cosine * down - pitch_sine * forward
    focal = np.array([camera.fx_px, camera.fy_px]) / np.maximum(depth[0], 0.2)[:, None]
    far, by_depth, by_across, by_along = focal * np.stack([x * depth - right, y * depth - below], axis=-1)
    return PointMotions(
        ray[:, 2] / ray[:, 0],
        ray[:, 1] / ray[:, 0],
        by_depth,
        by_across,
        by_along,
        -far,
        information(flow, window_px, flow.gap_s, noise),
    )
