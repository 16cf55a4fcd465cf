"""Depths of points by first sightings that were found again, standing or lying on the road.

The picture of what stands grows alike in both directions, that of the road is foreshortened and grows down the picture
by the square. Matched as the one, what is the other seems to have moved: ends of dashes 20 m ahead stood 0.3 m high. So
each point is matched as both, and has the depth of the one match, and chi2 with the road by the better of the two.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vpf_sim.perception.triangulation import NoiseModel, Triangulation, triangulate
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers

Match = Callable[[Integers, Floats], tuple[Floats, Bools]]  # `perception.anchors.Anchors.aside_px` of a flow


@dataclass(frozen=True, slots=True)
class AskedConfig:
    """Which points are matched with the frame of their first sighting: all that their tracks let stand on the road."""

    near_m: float = 2.5  # of depth
    far_m: float = 32.0
    aside_m: float = 10.0
    least_height_m: float = 0.03
    most_height_m: float = 2.5
    chi2_limit: float = 30.0  # of a point against its own depth
    chi2_margin: float = 5.0  # by which the road must fit worse
    road_m: float = 60.0  # up to where a ray meets the road, they are matched as if they lay there as well

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")

    def asked(self, points: Triangulation) -> Bools:
        """(N,) points that stand above the road, or seem to, by their chained tracks."""
        with np.errstate(invalid="ignore"):
            asked = (points.depth_m > self.near_m) & (points.depth_m < self.far_m)
            asked &= (points.height_m > self.least_height_m) & (points.height_m < self.most_height_m)
            asked &= (np.abs(points.right_m) < self.aside_m) & (points.chi2 < self.chi2_limit)
            return np.asarray(asked & (points.chi2_ground - points.chi2 > self.chi2_margin))


def sharpened(
    flow: Flow,
    points: Triangulation,
    rows: Integers,
    match: Match,
    camera: Camera,
    window_px: int,
    age_s: Floats,
    noise: NoiseModel,
    road_m: float,
) -> Triangulation:
    """The points of a flow, `age_s` (N,) old, with some `rows` of them matched with their first sightings."""

    def matched(of: Integers, growth: Floats) -> tuple[Triangulation, Integers]:
        """The points by a match of some of them, and which were found."""
        aside, found = match(of, growth)
        first, age = flow.first_px.copy(), age_s.copy()
        first[of[found]] += aside[found]
        age[of[found]] = 0.0
        return triangulate(replace(flow, first_px=first), camera, window_px, age, noise), of[found]

    way = np.hypot(*(flow.pose[:2] - flow.first_pose[rows, :2]).T)
    upright = 1.0 + way / points.depth_m[rows]
    standing, _ = matched(rows, np.stack([upright, upright], axis=1))
    below = (flow.points_px[rows, 1] - camera.cy_px) / camera.fy_px + np.tan(camera.pitch_rad)
    lies = below * road_m > camera.height_m
    if not lies.any():
        return standing
    across = 1.0 + way[lies] * below[lies] / camera.height_m
    lying, found = matched(rows[lies], np.stack([across, across**2], axis=1))
    chi2_ground = standing.chi2_ground.copy()
    chi2_ground[found] = np.minimum(chi2_ground[found], lying.chi2_ground[found])
    return replace(standing, chi2_ground=chi2_ground)
