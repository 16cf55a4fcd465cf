"""Actors that cross, or come in a bend: clusters of points that a static scene does not explain.

A static point moves along the line through the focus of expansion, no less than the road behind it. What moves across
leaves that line. With the inverse depth w and the speed across u, the motion of a point is linear in w and u w. The
motion of a small actor hardly shows w, so its foot bounds it: the lowest point stands on the road or above. Motion
fixes place and speed up to a common scale: what crosses is placed as if it did not move along, unless it would hang in
the air and come towards the car faster than across. Then its foot is on the road.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.obstacles.point_motion import PointMotions
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers, LateralExtents

GROUND_SHARE = 0.93  # of the inverse depth of the road behind a point: static points have no less
DROPS = (-0.35, 0.6)  # slopes of the rays that count
LINK_PX = (35.0, 70.0)  # between points of one actor, across and down
LINK_PX_PER_S, LINK_SHARE = 8.0, 0.3  # by which their motions may differ
FOOT_M = 0.1  # height of the lowest corner on an actor
NEARER, NEARER_SIGMA = 1.15, 0.3  # ratio of the depth of the foot's ray on the road to that of the actor
FOOT_SIGMA = 0.1  # the same where the motion would place it beyond
PASSES, CHI2_MEMBER, ACROSS_SIGMA = 5, 40.0, 100.0  # the last is of u w by the prior: any
LEAST_SHARE = 0.4  # of a cluster's points that agree
SIGMAS = 3.0  # of the speed across, by which it surely moves
TOPS_M, HIGHEST_FOOT_M = (0.75, 3.5), 1.0  # of an actor by its points
COMES_MPS = 2.0  # towards the car, from which an actor may be oncoming traffic
AROUND_PX = 8.0  # about its points, where others may be its own


@settings
class CrossingConfig:
    """Clusters of points that move across the road."""

    static_chi2: float = setting("Chi2 above which a point does not belong to the static scene.", gt=0.0)
    least_points: int = setting("Least number of points of a crossing actor.", ge=2)
    least_mps: float = setting("Least speed of an actor across the road.", gt=0.0)
    fastest_mps: float = setting("Largest speed across of an actor.", gt=0.0)
    farthest_m: float = setting("Largest depth of an actor.", gt=0.0)


@dataclass(frozen=True, slots=True)
class Crossers(LateralExtents):
    """K actors that move across, or come, in vehicle axes."""

    depth_m: Floats  # (K,) from the camera
    left_m: Floats  # (K,) of their visible points
    right_m: Floats  # (K,)
    speed_mps: Floats  # (K,) to the right
    along_mps: Floats  # (K,) forward
    depth_sigma_m: Floats  # (K,)
    speed_sigma_mps: Floats  # (K,) at that depth

    def __len__(self) -> int:
        return len(self.depth_m)


def nobody() -> Crossers:
    """None at all."""
    return Crossers(*np.empty((7, 0)))


class CrossingDetector:
    """Finds actors that cross, frame by frame."""

    def __init__(self, camera: Camera, config: CrossingConfig) -> None:
        self._camera, self._config = camera, config

    def find(self, flow: Flow, motions: PointMotions, own_mps: float) -> tuple[Crossers, Bools]:
        """The actors that cross, and (N,) points of the flow that are theirs or nearby."""
        config, near = self._config, np.zeros(len(flow), np.bool_)
        rows = np.flatnonzero(self._moves(flow, motions))
        found = []
        if len(rows) >= config.least_points:
            labels = _clusters(flow.points_px[rows], motions.far[rows] / flow.gap_s[rows, None])
            for label in np.flatnonzero(np.bincount(labels) >= config.least_points).tolist():
                cluster = rows[labels == label]
                actor = _actor(motions.select(cluster), self._camera, config, own_mps)
                if actor is not None:
                    found.append(actor)
                    near |= _around(flow.points_px, flow.points_px[cluster])
        return Crossers(*np.array(found, float).reshape(-1, 7).T), near

    def _moves(self, flow: Flow, motions: PointMotions) -> Bools:
        """(N,) points that do not belong to the static scene."""
        least_per_m = GROUND_SHARE * np.maximum(motions.drop, 0.0) / self._camera.height_m
        moves: Bools = motions.static_chi2(least_per_m) > self._config.static_chi2
        moves &= (motions.drop > DROPS[0]) & (motions.drop < DROPS[1]) & (flow.age_frames >= 1)
        return moves & ~flow.on_glass if len(flow.on_glass) else moves


def _around(points_px: Floats, cluster_px: Floats) -> Bools:
    """(N,) points in the upright box about a cluster's points."""
    low, high = cluster_px.min(axis=0) - AROUND_PX, cluster_px.max(axis=0) + AROUND_PX
    return np.asarray(((points_px > low) & (points_px < high)).all(axis=1))


def _clusters(points_px: Floats, motion_px_per_s: Floats) -> Integers:
    """(N,) labels of points that are near each other and move alike."""
    apart = np.abs(points_px[:, None] - points_px)
    speed = np.hypot(*motion_px_per_s.T)
    differs = np.hypot(*np.moveaxis(motion_px_per_s[:, None] - motion_px_per_s, -1, 0))
    alike = differs < LINK_PX_PER_S + LINK_SHARE * np.minimum(speed[:, None], speed)
    near: Bools = np.all(apart < LINK_PX, axis=-1) & alike
    return np.asarray(connected_components(near)[1])


def _actor(points: PointMotions, camera: Camera, config: CrossingConfig, own_mps: float) -> tuple[float, ...] | None:
    """A row of `Crossers` by the points of a cluster; None if they are none."""
    lowest = float(points.drop.max())
    if lowest * config.farthest_m < camera.height_m - FOOT_M:
        return None
    foot_per_m = lowest / (camera.height_m - FOOT_M)
    inverse, across, sigma, chi2 = _fit(points, NEARER * foot_per_m, NEARER_SIGMA * foot_per_m)
    if inverse < foot_per_m:
        inverse, across, sigma, chi2 = _fit(points, foot_per_m, 1e-3 * foot_per_m)
        sigma = FOOT_SIGMA * foot_per_m, sigma[1]
    members = chi2 < CHI2_MEMBER
    depth, along = 1.0 / inverse, 0.0
    coming = own_mps * (inverse / foot_per_m - 1.0)
    if coming > max(COMES_MPS, abs(across) / foot_per_m):
        depth, along = 1.0 / foot_per_m, -coming
        sigma = FOOT_SIGMA * foot_per_m, sigma[1]
    speed, speed_sigma = across * depth, sigma[1] * depth
    count = np.count_nonzero(members)
    if count < max(config.least_points, LEAST_SHARE * len(chi2)) or not config.least_mps + SIGMAS * speed_sigma < abs(
        speed
    ):
        return None
    drop, bearing = points.drop[members], points.bearing[members]
    top, foot = camera.height_m - drop.min() * depth, camera.height_m - drop.max() * depth
    if (
        not TOPS_M[0] < top < TOPS_M[1]
        or foot > HIGHEST_FOOT_M
        or depth > config.farthest_m
        or abs(speed) > config.fastest_mps
    ):
        return None
    return depth, bearing.min() * depth, bearing.max() * depth, speed, along, sigma[0] * depth**2, speed_sigma


def _fit(
    points: PointMotions, prior_per_m: float, prior_sigma_per_m: float
) -> tuple[float, float, tuple[float, float], Floats]:
    """Inverse depth w, u w, their standard deviations and (N,) chi2."""
    slope = np.stack([points.by_depth, points.by_across], axis=2)
    mean, prior_sigma = np.array([prior_per_m, 0.0]), np.array([prior_sigma_per_m, ACROSS_SIGMA])
    (inverse, across), (sigma, across_sigma), chi2 = points.fit(slope, mean, prior_sigma, PASSES)
    return float(inverse), float(across), (float(sigma), float(across_sigma)), chi2
