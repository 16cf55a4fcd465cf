"""Points a hand's breadth above the road, of pallets, planks, tyres: it takes several to be sure of their height."""

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.config import LowObstacleConfig, NearbyConfig
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Integers, Obstacles, RoadEdges


def is_low(points: Triangulation, age_s: Floats, texture: Floats, config: LowObstacleConfig) -> Bools:
    """(N,) points that stand too low to be told one by one, by their own tracks and the small eigenvalues (N,)."""
    with np.errstate(invalid="ignore"):
        low = (points.depth_m > config.near_m) & (points.depth_m < config.far_m) & (age_s >= config.min_age_s)
        low &= texture > config.least_texture
        low &= (points.chi2 < config.chi2_limit) & (points.chi2_ground - points.chi2 > config.chi2_margin)
        low &= (points.height_m > config.min_height_m) & (points.height_m < config.max_height_m)
        low &= points.height_sigma_m < config.sigma_height_m
    return low


def off_lines(camera: Camera, foot_m: Floats, road: RoadEdges, config: LowObstacleConfig) -> Bools:
    """(N,) places (N, 2) on the flat road, vehicle axes, within the carriageway and on no painted line.

    Lines are a lane's width apart; along the axes of a turned vehicle farther.
    """
    lane_width_m = road.lane_width_m
    left, right = carriageway_offsets(foot_m[:, 0], road)
    lanes = max(round((road.right_m - road.left_m) / lane_width_m), 1)
    across = (foot_m[:, 1] - left) / (right - left) * lanes
    aside = np.abs(across - np.rint(across)) * lane_width_m
    halo = config.line_px * (foot_m[:, 0] - camera.forward_m) / camera.fx_px
    is_edge = (np.rint(across) <= 0.0) | (np.rint(across) >= lanes)
    off: Bools = (across > 0.0) & (across < lanes) & (aside > np.where(is_edge, config.edge_m, config.line_m) + halo)
    return off


def in_shadow(place_m: Floats, tall: Obstacles, config: NearbyConfig) -> Bools:
    """(M,) points (M, 2), vehicle axes, beside a taller body, where its shadow may lie: its corner seems to stand."""
    along_m, across_m = config.along_m, config.across_m
    behind, right = place_m[:, :1] - tall.forward_m, place_m[:, 1:]
    near = (behind > -across_m) & (behind < along_m)
    near &= (right > tall.left_m - across_m) & (right < tall.right_m + across_m)
    shaded: Bools = np.any(near, axis=1)
    return shaded


def belongs_to(place_m: Floats, parts_m: Floats, parts_of: Integers, tall: Obstacles, config: NearbyConfig) -> Bools:
    """(M,) low points (M, 2) beside one (P, 2) of a taller body, as its wheels are; `parts_of` (P,) tells of which.

    What lies before the face that is told of that body is not of it, whatever was taken for one of its points.
    """
    along_m, across_m = config.along_m, config.across_m
    gap = np.abs(place_m[:, None] - parts_m)
    same = parts_of[:, None] == tall.identity
    face = np.min(np.broadcast_to(tall.forward_m, same.shape), axis=1, where=same, initial=np.inf)
    behind = place_m[:, :1] > face - along_m
    part: Bools = np.any((gap[..., 0] < along_m) & (gap[..., 1] < across_m) & behind, axis=1)
    return part
