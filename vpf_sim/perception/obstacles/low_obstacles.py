"""Points a hand's breadth above the road, of pallets, planks, tyres: it takes several to be sure of their height."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Integers, Obstacles, RoadEdges


@dataclass(frozen=True, slots=True)
class LowObstacleConfig:
    """When a point counts as low, and how many of them make a body."""

    near_m: float = 3.0  # range of depth in which points are judged
    far_m: float = 14.0
    min_age_s: float = 0.15
    min_height_m: float = 0.05
    max_height_m: float = 0.25
    sigma_height_m: float = 0.04  # largest
    chi2_limit: float = 9.0  # of a point against its own depth
    chi2_margin: float = 12.0  # by which the road must fit worse
    line_m: float = 0.2  # points whose foot on the road lies so near a line are not trusted: ends of dashes slide
    line_px: float = 4.0  # besides, half of the flow's window
    edge_m: float = 0.4  # the same of the edge lines
    link_right_m: float = 0.9  # points nearer than this belong to one body
    link_forward_m: float = 1.4
    # small eigenvalue, grey levels^2 / px^2: asphalt has 5 to 13 and slides, ends of dashes 15 to 30, what stands 33
    least_texture: float = 25.0
    least_points: int = 2
    least_margin: float = 60.0  # sum over the points of a body, of which one adds
    most_margin: float = 100.0  # at most this
    single_margin: float = 150.0  # one alone needs this,
    single_texture: float = 30.0  # a corner so clear (small eigenvalue, grey levels^2 / px^2): asphalt slides
    single_hits_s: float = 0.3  # and so long
    least_width_m: float = 0.6  # a body is told no narrower
    beside_m: float = 0.4  # points so near a taller body are of it, unless
    sticks_out_m: float = 1.0  # they reach so far out of it as the corner of a car's shadow does not,
    sticks_out_share: float = 0.5  # or by this share of its width, which of a pedestrian any low body beside him does,
    before_m: float = 1.0  # or so far before its face,
    part_m: tuple[float, float] = (0.8, 0.4)  # and those so near one of its points, along and across
    shade_m: tuple[float, float] = (8.0, 1.2)  # behind a taller body's face and beside it, where it takes a point more

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")
        if not 0.0 < self.min_height_m < self.max_height_m:
            raise ValueError(
                f"min_height_m, max_height_m: expected 0 < min < max, got {self.min_height_m}, {self.max_height_m}"
            )
        if not self.sticks_out_share > 0.0:
            raise ValueError(f"sticks_out_share: expected > 0, got {self.sticks_out_share}")
        for key in ("part_m", "shade_m"):
            if not min(getattr(self, key)) > 0.0:
                raise ValueError(f"{key}: expected both > 0, got {getattr(self, key)}")


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


def in_shadow(place_m: Floats, tall: Obstacles, config: LowObstacleConfig) -> Bools:
    """(M,) points (M, 2), vehicle axes, beside a taller body, where its shadow may lie: its corner seems to stand."""
    along_m, across_m = config.shade_m
    behind, right = place_m[:, :1] - tall.forward_m, place_m[:, 1:]
    near = (behind > -across_m) & (behind < along_m)
    near &= (right > tall.left_m - across_m) & (right < tall.right_m + across_m)
    shaded: Bools = np.any(near, axis=1)
    return shaded


def belongs_to(
    place_m: Floats, parts_m: Floats, parts_of: Integers, tall: Obstacles, config: LowObstacleConfig
) -> Bools:
    """(M,) low points (M, 2) beside one (P, 2) of a taller body, as its wheels are; `parts_of` (P,) tells of which.

    What lies before the face that is told of that body is not of it, whatever was taken for one of its points.
    """
    along_m, across_m = config.part_m
    gap = np.abs(place_m[:, None] - parts_m)
    same = parts_of[:, None] == tall.identity
    face = np.min(np.broadcast_to(tall.forward_m, same.shape), axis=1, where=same, initial=np.inf)
    behind = place_m[:, :1] > face - along_m
    part: Bools = np.any((gap[..., 0] < along_m) & (gap[..., 1] < across_m) & behind, axis=1)
    return part
