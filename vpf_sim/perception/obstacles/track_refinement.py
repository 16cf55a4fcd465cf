"""Depths of points matched with their first observation, as a standing surface and as road.

The image of a standing surface grows alike in both directions; that of the road is foreshortened and grows down the
image by the square. Matched with the wrong model, a point seems to have moved: ends of dashes 20 m ahead seemed 0.3 m
high. So each point is matched as both. It takes its depth from the standing match, its chi2 on the road from the better
of the two.
"""

from collections.abc import Callable

import numpy as np

from vpf_sim.perception.egomotion.ground_plane import below_horizon
from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.static_obstacle_settings import RefinementConfig
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Flow, Integers, RoadEdges

Triangulate = Callable[[Integers, Floats], Triangulation]  # rows of a flow, first observed some px aside
Match = Callable[[Integers, Floats], tuple[Floats, Bools]]  # `KeyframeBuffer.register` of a flow


def candidates(
    points: Triangulation, road: RoadEdges, camera: Camera, config: RefinementConfig, range_factor: float
) -> Integers:
    """(n,) rows of points that may be above the road by their chained tracks.

    `range_factor` is that of `StaticObstacleConfig`.
    """
    with np.errstate(invalid="ignore"):
        chosen = (points.depth_m > config.near_m) & (points.depth_m < range_factor * config.far_m)
        chosen &= (points.height_m > config.least_height_m) & (points.height_m < config.most_height_m)
        chosen &= (points.chi2 < config.chi2_limit) & (points.chi2_ground - points.chi2 > config.chi2_margin)
    rows = np.flatnonzero(chosen).astype(np.int64)
    left, right = carriageway_offsets(camera.forward_m + points.depth_m[rows], road)
    aside = points.right_m[rows]
    return rows[(aside > left - config.edge_m) & (aside < right + config.edge_m)]


def refined(
    flow: Flow,
    points: Triangulation,
    rows: Integers,
    match: Match,
    config: RefinementConfig,
    triangulate: Triangulate,
    camera: Camera,
) -> Triangulation:
    """The points of a flow, `rows` of them (at least one) matched with their first observation."""
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
    matched, stands = triangulate(both[found], aside[found]), np.flatnonzero(found) < len(rows)
    result = {name: getattr(points, name).copy() for name in Triangulation.__slots__}
    for name, values in result.items():
        values[both[found][stands]] = getattr(matched, name)[stands]
    lying = both[found][~stands]
    result["chi2_ground"][lying] = np.minimum(result["chi2_ground"][lying], matched.chi2_ground[~stands])
    return Triangulation(**result)
