"""The region of interest A of the paper's obstacle force: which image points may be obstacles (section IV-B).

The paper prints "with A defined as in (A)", which points at a matrix, and says that |R| "is the region of interest in
the image". It prints a horizon of 5 s, 27.5 m at 20 km/h, for its road field. `docs/reproduce.md` lists the readings.
"""

from dataclasses import dataclass, field
from math import tan

import numpy as np

from vpf_sim.perception.paper.paper_settings import RegionConfig
from vpf_sim.types import Bools, Camera, Floats, RoadEdges


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What the region depends on beside the image: the road as it is seen, and the vehicle's speed."""

    road: RoadEdges
    speed_mps: float
    ttc_s: Floats = field(default_factory=lambda: np.empty(0))  # (N,) of each point alone


def inside(points_px: Floats, camera: Camera, around: Surroundings, config: RegionConfig) -> Bools:
    """(N,) which points (N, 2) lie in the region.

    A standing point has the depth Z = speed x time to contact. At X = Z + the camera's place it stands
    y = (u - cx) Z / fx to the right of the vehicle's axis, and camera height - (v - cy) Z / fy above the road. There
    the road has gone heading X + curvature X^2 / 2 to the right.
    """
    if config.shape == "full_frame":
        return np.ones(len(points_px), np.bool_)
    below = points_px[:, 1] - camera.cy_px + camera.fy_px * tan(camera.pitch_rad)
    if config.shape == "below_horizon":
        return np.asarray(below > 0.0)
    known = np.isfinite(around.ttc_s)
    depth = np.where(known, around.ttc_s, 0.0) * around.speed_mps
    reach_m = config.reach_m if config.shape == "horizon_corridor" else np.inf
    ahead, road = depth + camera.forward_m, around.road
    across = (points_px[:, 0] - camera.cx_px) * depth / camera.fx_px
    across -= road.heading_rad * ahead + 0.5 * road.curvature_per_m * ahead**2
    height = camera.height_m - below * depth / camera.fy_px
    return np.asarray(
        known
        & (depth > config.near_m)
        & (depth < reach_m)
        & (across > road.left_m + config.margin_m)
        & (across < road.right_m - config.margin_m)
        & (height > config.height_m[0])
        & (height < config.height_m[1])
    )
