"""Points of oncoming traffic, which look as if they stood nearer and hung in the air.

A vehicle at the depth Z that comes at u towards a car at v is triangulated as if it stood, at Z v / (v + u): the time
to contact is right, the place is not, and no motion of its image tells the two apart. But its foot is on the road at Z,
so it seems to hang at the height h u / (v + u), with the camera at h. What stands has something below.
"""

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.static_obstacle_settings import OncomingConfig, StaticObstacleConfig
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Integers, RoadEdges

RATIOS = 12  # of the depths that are tried


def come_towards(
    points: Triangulation, tall: Integers, road: RoadEdges, camera: Camera, config: StaticObstacleConfig
) -> Bools:
    """(n,) which of the points `tall` (n,), in the own lanes, are of traffic in the lanes of the other direction."""
    oncoming = config.oncoming
    if oncoming is None or not road.oncoming_m or not len(tall):
        return np.zeros(len(tall), np.bool_)
    depth, right = points.depth_m[tall], points.right_m[tall]
    sure = (points.chi2 < config.chi2_limit) & (points.sigma_m < config.depth_ratio * points.depth_m)
    low = np.flatnonzero(sure & (points.height_m > oncoming.lowest_m) & (points.height_m < oncoming.hangs_m))
    beside = np.abs(points.right_m[low] - right[:, None]) < oncoming.across_m
    near = np.abs(points.depth_m[low] - depth[:, None]) < oncoming.along_share * depth[:, None]
    hangs = (points.height_m[tall] > oncoming.hangs_m) & ~np.any(beside & near, axis=1)
    return np.asarray(hangs & _before_oncoming_lanes(depth, right, road, camera, oncoming))


def _before_oncoming_lanes(
    depth_m: Floats, right_m: Floats, road: RoadEdges, camera: Camera, config: OncomingConfig
) -> Bools:
    """(n,) whether the line of sight through a point leads on to the lanes of oncoming traffic."""
    ratio = np.geomspace(config.nearest_ratio, config.farthest_ratio, RATIOS)
    left, _ = carriageway_offsets(camera.forward_m + depth_m[:, None] * ratio, road)
    aside = right_m[:, None] * ratio
    return np.asarray(np.any((aside < left) & (aside > left - road.oncoming_m), axis=1))
