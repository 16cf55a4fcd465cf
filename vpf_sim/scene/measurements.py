"""Detections for the tracker, from what perception reports."""

import numpy as np

from vpf_sim.geometry import world_from_vehicle
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.object_sizes import ObjectSizes
from vpf_sim.perception.obstacles.crossing import Crossers
from vpf_sim.scene.road import Road
from vpf_sim.scene.tracker import Detections
from vpf_sim.types import Floats, Obstacles

ALONG_SIGMA_M, ACROSS_SIGMA_M, MOVING_ACROSS_SIGMA_M = 0.2, 0.12, 0.25  # at least
STANDING_SIGMA_MPS, MOVING_SIGMA_MPS = 0.05, 0.5
CONFIRMED = 4.0  # log-odds that an obstacle adds which perception has confirmed by itself

BORN_M, NEAR = 8.0, 0.3  # what stands and appears nearer should have been seen before: it adds less, or nothing
HEIGHT_M, HEIGHT_SIGMA_M = 0.06, 0.06  # of a point that supports an obstacle
CHI2, CHI2_MARGIN = 9.0, 12.0  # of it as a static point, at most, and how much more on the road
BEFORE_M, BEHIND_M, ASIDE_M = 0.6, 1.5, 0.3  # of its face and beside it, where such points are
TRUE_RATE, FALSE_RATE = 2.0, 0.5  # such points in a frame on an obstacle, at least, and on paint
SUPPORT_M = (3.0, 8.0)  # where they are expected, from the pose
SHARE = 0.5  # of their log-likelihood: points stay from frame to frame
STANDING_MPS = 0.5  # a slower car finds no heights
CROSSER = 0.7  # the same of a cluster of points in one frame
STATIC_LOSS_PER_S, MOVING_LOSS_PER_S, CROSSER_LOSS_PER_S = 20.0, 2.0, 2.5  # log-odds, while not detected in sight
BESIDE_M = 3.0  # from the edges, where actors that cross may come from
NARROWEST_M, DEEP_M = 0.6, 0.6  # of what crosses: its width at least, and its size along the road
CROSSER_SIGMA_M, CROSSER_SIGMA_MPS = 0.3, (1.0, 0.3)  # across; along and across, at least


def of_obstacles(
    obstacles: Obstacles, odds: Floats, pose: Floats, road: Road, s_m: float, sizes: ObjectSizes
) -> Detections:
    """Obstacles in the axes of a car at a pose (x m, y m, yaw rad), `s_m` along the road; lengths by class.

    `odds` (K,) are the log-odds of `support`.
    """
    count = len(obstacles)
    s, d = _on_road(obstacles.forward_m, obstacles.middle_m, pose, road, s_m)
    moving = obstacles.speed_mps != 0.0
    sigma = np.empty((count, 4))
    sigma[:, 0] = np.clip(obstacles.sigma_m, ALONG_SIGMA_M, 2.0)
    sigma[:, 1] = np.where(moving, MOVING_ACROSS_SIGMA_M, ACROSS_SIGMA_M)
    sigma[:, 2:] = np.where(moving, MOVING_SIGMA_MPS, STANDING_SIGMA_MPS)[:, None]
    covariance = np.eye(4) * (sigma**2)[:, None, :]
    state = np.stack([s, d, obstacles.speed_mps, np.zeros(count)], axis=1)
    width = obstacles.width_m
    loss = np.where(moving, MOVING_LOSS_PER_S, STATIC_LOSS_PER_S)
    unjudged = np.where(obstacles.forward_m > SUPPORT_M[0], NEAR, 0.0)
    gain = np.where(moving | (obstacles.forward_m > BORN_M), CONFIRMED, np.where(np.isnan(odds), unjudged, odds))
    return Detections(state, covariance, sizes.lengths_m(width), width, gain, loss)


def support(obstacles: Obstacles, points: Triangulation, camera_m: float, own_mps: float) -> Floats:
    """(K,) log-odds by the number of points above the road on static obstacles; nan where none are expected.

    Poisson likelihoods of an obstacle and of paint, which lies in the plane.
    """
    with np.errstate(invalid="ignore"):
        above = (points.height_m > HEIGHT_M) & (points.height_sigma_m < HEIGHT_SIGMA_M)
        above &= (points.chi2 < CHI2) & (points.chi2_ground - points.chi2 > CHI2_MARGIN)
    forward, right = camera_m + points.depth_m[above], points.right_m[above]
    behind = forward - obstacles.forward_m[:, None]
    there = (behind > -BEFORE_M) & (behind < BEHIND_M)
    there &= (right > obstacles.left_m[:, None] - ASIDE_M) & (right < obstacles.right_m[:, None] + ASIDE_M)
    count = np.count_nonzero(there, axis=1)
    odds = SHARE * (count * np.log(TRUE_RATE / FALSE_RATE) - (TRUE_RATE - FALSE_RATE))
    visible = (obstacles.forward_m > SUPPORT_M[0]) & (obstacles.forward_m < SUPPORT_M[1]) & (own_mps > STANDING_MPS)
    return np.where(visible, np.minimum(odds, CONFIRMED), np.nan)


def of_crossers(crossers: Crossers, camera_m: float, pose: Floats, road: Road, s_m: float) -> Detections:
    """Actors that cross, of a camera `camera_m` ahead of a pose; those far beside the road are left out."""
    forward = camera_m + crossers.depth_m
    s, d = _on_road(forward, crossers.middle_m, pose, road, s_m)
    here = road.at(s)
    turn = float(pose[2]) - here.heading_rad
    along = np.cos(turn) * crossers.along_mps - np.sin(turn) * crossers.speed_mps
    across = np.sin(turn) * crossers.along_mps + np.cos(turn) * crossers.speed_mps
    sigma = np.empty((len(crossers), 4))
    sigma[:, 0] = crossers.depth_sigma_m
    sigma[:, 1] = np.hypot(CROSSER_SIGMA_M, np.abs(crossers.middle_m) / crossers.depth_m * crossers.depth_sigma_m)
    relative = crossers.depth_sigma_m / crossers.depth_m  # a farther actor is a faster one
    sigma[:, 2] = np.hypot(CROSSER_SIGMA_MPS[0], relative * crossers.along_mps)
    sigma[:, 3] = np.hypot(CROSSER_SIGMA_MPS[1], np.hypot(crossers.speed_sigma_mps, relative * crossers.speed_mps))
    covariance = np.eye(4) * (sigma**2)[:, None, :]
    near = (d > here.left_m - BESIDE_M) & (d < here.right_m + BESIDE_M)
    width, same = np.maximum(crossers.width_m, NARROWEST_M), np.ones(len(crossers))
    found = Detections(
        np.stack([s, d, along, across], axis=1),
        covariance,
        DEEP_M * same,
        width,
        CROSSER * same,
        CROSSER_LOSS_PER_S * same,
    )
    return found.chosen(near)


def _on_road(forward_m: Floats, right_m: Floats, pose: Floats, road: Road, s_m: float) -> tuple[Floats, Floats]:
    """s and d of places in vehicle axes."""
    x, y = world_from_vehicle(np.column_stack([forward_m, right_m]), pose).T
    return road.place_at(x, y, s_m + forward_m)
