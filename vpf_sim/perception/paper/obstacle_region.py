"""The region of interest A of the paper's obstacle force: which image points may be obstacles (section IV-B).

The paper prints "with A defined as in (A)", which points at a matrix, and says that |R| "is the region of interest in
the image". It prints a horizon of 5 s, 27.5 m at 20 km/h, for its road field. `docs/readings.md` lists the readings.
"""

from dataclasses import dataclass, field
from math import tan
from typing import Literal

import numpy as np

from vpf_sim.types import Bools, Camera, Floats, RoadEdges

Shape = Literal["full_frame", "below_horizon", "road_corridor", "horizon_corridor"]


@dataclass(frozen=True, slots=True)
class RegionConfig:
    """`road_corridor`: what stands between the edges of the road; `horizon_corridor`: within `reach_m` of it."""

    shape: Shape = "full_frame"
    margin_m: float = 1.0  # inside the edges; points beside the road are placed with errors of that size
    near_m: float = 2.0  # least depth, from the camera
    reach_m: float = 27.5  # largest depth: 5 s at 20 km/h, as printed
    height_m: tuple[float, float] = (0.2, 2.5)  # above the road

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.reach_m:
            raise ValueError(f"near_m, reach_m: expected 0 < near_m < reach_m, got {self.near_m}, {self.reach_m}")
        if not self.height_m[0] < self.height_m[1]:
            raise ValueError(f"height_m: expected the lower limit first, got {list(self.height_m)}")

    @property
    def needs_depth(self) -> bool:
        """Whether the time to contact of the points decides."""
        return self.shape in ("road_corridor", "horizon_corridor")


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
