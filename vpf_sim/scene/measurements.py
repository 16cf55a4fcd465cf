"""Detections for the tracker, from what perception reports."""

import numpy as np

from vpf_sim.geometry import world_from_vehicle
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.object_sizes import lengths_m
from vpf_sim.perception.obstacles.crossing import Crossers
from vpf_sim.scene.road import Road
from vpf_sim.scene.scene_settings import ExistenceConfig
from vpf_sim.scene.tracker import Detections
from vpf_sim.types import Bools, Floats, Obstacles

ALONG_SIGMA_M, ACROSS_SIGMA_M, MOVING_ACROSS_SIGMA_M = 0.2, 0.12, 0.25  # at least
STANDING_SIGMA_MPS, MOVING_SIGMA_MPS = 0.05, 0.5
HEIGHT_M, HEIGHT_SIGMA_M = 0.06, 0.06  # of a point that supports an obstacle
CHI2, CHI2_MARGIN = 9.0, 12.0  # of it as a static point, at most, and how much more on the road
BEFORE_M, BEHIND_M, ASIDE_M = 0.6, 1.5, 0.3  # of its face and beside it, where such points are
SUPPORT_M = (3.0, 8.0)  # where they are expected, from the pose
BEARING = 0.8  # tangent of the angle from the course, up to which obstacles show
LEAST_WIDTH_M = 0.1  # of a face that has none
STANDING_MPS = 0.5  # a slower car finds no heights
ROW_M, ROW_GAP_M = 3.0, 0.6  # along and across, between faces that may be one vehicle's
BESIDE_M = 3.0  # from the edges, where actors that cross may come from
NARROWEST_M, DEEP_M = 0.6, 0.6  # of what crosses: its width at least, and its size along the road
CROSSER_SIGMA_M, CROSSER_SIGMA_MPS = 0.3, (1.0, 0.3)  # across; along and across, at least


def of_obstacles(
    obstacles: Obstacles,
    odds: Floats,
    relief: Floats,
    pose: Floats,
    road: Road,
    s_m: float,
    config: ExistenceConfig,
) -> Detections:
    """Obstacles in the axes of a car at a pose (x m, y m, yaw rad), `s_m` along the road; lengths by class.

    `odds` (K,) are the log-odds of `support`; `relief` (K,) is -1 of what lies in the road's plane.
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
    loss = np.where(moving, config.moving_per_s, config.standing_per_s)
    unjudged = np.where(obstacles.forward_m > SUPPORT_M[0], config.near, 0.0)
    surely = moving | (obstacles.forward_m > config.born_m)
    gain = np.where(surely, config.confirmed, np.where(np.isnan(odds), unjudged, odds))
    gain = np.where(~moving & (relief < config.flat), config.per_relief * relief, gain)
    length = lengths_m(_whole_widths(s, d, width, moving))
    return Detections(state, covariance, length, width, gain, loss)


def _whole_widths(s_m: Floats, d_m: Floats, width_m: Floats, moving: Bools) -> Floats:
    """(K,) widths, of standing faces with those beside them: a narrow one may be a vehicle behind another."""
    left, right = d_m - 0.5 * width_m, d_m + 0.5 * width_m
    beside = (left < right[:, None] + ROW_GAP_M) & (right > left[:, None] - ROW_GAP_M)
    beside &= (np.abs(s_m - s_m[:, None]) < ROW_M) & ~moving & ~moving[:, None] | np.eye(len(s_m), dtype=np.bool_)
    whole_right = np.where(beside, right, -np.inf).max(axis=1, initial=-np.inf)
    whole: Floats = whole_right - np.where(beside, left, np.inf).min(axis=1, initial=np.inf)
    return whole


def support(
    obstacles: Obstacles, points: Triangulation, camera_m: float, own_mps: float, config: ExistenceConfig
) -> Floats:
    """(K,) log-odds by the number of points above the road on static obstacles; nan where none are expected.

    Poisson likelihoods of an obstacle and of paint, which lies in the plane; of an obstacle that is partly out of view
    fewer points are expected.
    """
    with np.errstate(invalid="ignore"):
        above = (points.height_m > HEIGHT_M) & (points.height_sigma_m < HEIGHT_SIGMA_M)
        above &= (points.chi2 < CHI2) & (points.chi2_ground - points.chi2 > CHI2_MARGIN)
    forward, right = camera_m + points.depth_m[above], points.right_m[above]
    behind = forward - obstacles.forward_m[:, None]
    there = (behind > -BEFORE_M) & (behind < BEHIND_M)
    there &= (right > obstacles.left_m[:, None] - ASIDE_M) & (right < obstacles.right_m[:, None] + ASIDE_M)
    count = np.count_nonzero(there, axis=1)
    expected, mistaken = config.obstacle_points, config.paint_points
    view_m, half = BEARING * obstacles.forward_m, 0.5 * LEAST_WIDTH_M
    in_view = np.minimum(obstacles.right_m + half, view_m) - np.maximum(obstacles.left_m - half, -view_m)
    share = np.clip(in_view / (obstacles.width_m + 2.0 * half), 0.0, 1.0)
    odds = config.points_share * (count * np.log(expected / mistaken) - share * (expected - mistaken))
    visible = (
        (share > 0.0)
        & (obstacles.forward_m > SUPPORT_M[0])
        & (obstacles.forward_m < SUPPORT_M[1])
        & (own_mps > STANDING_MPS)
    )
    return np.where(visible, np.minimum(odds, config.points_most), np.nan)


def of_crossers(
    crossers: Crossers, camera_m: float, pose: Floats, road: Road, s_m: float, config: ExistenceConfig
) -> Detections:
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
        config.crossing * same,
        config.crossing_per_s * same,
    )
    return found.select(near)


def _on_road(forward_m: Floats, right_m: Floats, pose: Floats, road: Road, s_m: float) -> tuple[Floats, Floats]:
    """s and d of places in vehicle axes."""
    x, y = world_from_vehicle(np.column_stack([forward_m, right_m]), pose).T
    return road.place_at(x, y, s_m + forward_m)
