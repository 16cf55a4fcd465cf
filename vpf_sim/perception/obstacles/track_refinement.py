"""Depths of points by first sightings that were found again, standing or lying on the road.

The picture of what stands grows alike in both directions, that of the road is foreshortened and grows down the picture
by the square. Matched as the one, what is the other seems to have moved: ends of dashes 20 m ahead stood 0.3 m high. So
each point is matched as both, and has the depth of the one match, and chi2 with the road by the better of the two.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.egomotion.ground_plane import below_horizon
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers, RoadEdges

Again = Callable[[Integers, Floats], Triangulation]  # of rows of a flow, first seen aside of where it says
# `perception.egomotion.keyframes.KeyframeBuffer.aside_px` of a flow
Match = Callable[[Integers, Floats], tuple[Floats, Bools]]


@dataclass(frozen=True, slots=True)
class RefinementConfig:
    """Which points are matched with the frame of their first sighting: all that their tracks let stand on the road."""

    near_m: float = 2.5  # of depth
    far_m: float = 32.0
    edge_m: float = 1.0  # outside the carriageway
    least_height_m: float = 0.03
    most_height_m: float = 2.5
    chi2_limit: float = 30.0  # of a point against its own depth
    chi2_margin: float = 5.0  # by which the road must fit worse
    road_m: float = 60.0  # up to where a ray meets the road, they are matched as if they lay there as well

    def __post_init__(self) -> None:
        for low, high in (("near_m", "far_m"), ("least_height_m", "most_height_m")):
            least, most = getattr(self, low), getattr(self, high)
            if not 0.0 < least < most:
                raise ValueError(f"{low}, {high}: expected 0 < {low} < {high}, got {least}, {most}")
        if min(self.edge_m, self.chi2_limit, self.chi2_margin) < 0.0 or not self.road_m > 0.0:
            raise ValueError("edge_m, chi2_limit, chi2_margin: expected >= 0, and road_m > 0")

    def asked(self, points: Triangulation, road: RoadEdges, camera: Camera) -> Integers:
        """(n,) rows of points that stand above the road, or seem to, by their chained tracks."""
        with np.errstate(invalid="ignore"):
            asked = (points.depth_m > self.near_m) & (points.depth_m < self.far_m)
            asked &= (points.height_m > self.least_height_m) & (points.height_m < self.most_height_m)
            asked &= (points.chi2 < self.chi2_limit) & (points.chi2_ground - points.chi2 > self.chi2_margin)
        rows = np.flatnonzero(asked).astype(np.int64)
        left, right = carriageway_offsets(camera.forward_m + points.depth_m[rows], road)
        aside = points.right_m[rows]
        return rows[(aside > left - self.edge_m) & (aside < right + self.edge_m)]


def refined(
    flow: Flow,
    points: Triangulation,
    rows: Integers,
    match: Match,
    config: RefinementConfig,
    again: Again,
    camera: Camera,
) -> Triangulation:
    """The points of a flow with some `rows` of them, one at least, matched with their first sightings.

    `again` triangulates points of a flow that were found.
    """
    way = np.hypot(*(flow.pose[:2] - flow.first_pose[rows, :2]).T)
    upright = 1.0 + way / points.depth_m[rows]
    below = below_horizon(camera, flow.points_px[rows])
    lies = np.flatnonzero(below * config.road_m > camera.height_m)
    across = 1.0 + way[lies] * below[lies] / camera.height_m
    both = np.concatenate([rows, rows[lies]])
    growth = np.concatenate([np.stack([upright, upright], axis=1), np.stack([across, across**2], axis=1)])
    aside, found = match(both, growth)
    if not found.any():
        return points
    matched, stands = again(both[found], aside[found]), np.flatnonzero(found) < len(rows)
    result = {name: getattr(points, name).copy() for name in Triangulation.__slots__}
    for name, values in result.items():
        values[both[found][stands]] = getattr(matched, name)[stands]
    lying = both[found][~stands]
    result["chi2_ground"][lying] = np.minimum(result["chi2_ground"][lying], matched.chi2_ground[~stands])
    return Triangulation(**result)
