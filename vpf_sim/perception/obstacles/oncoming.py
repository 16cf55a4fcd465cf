"""Points of oncoming traffic, which look as if they stood nearer and hung in the air.

A vehicle at the depth Z that comes at u towards a car at v is triangulated as if it stood, at Z v / (v + u): the time
to contact is right, the place is not, and no motion of its image tells the two apart. But its foot is on the road at Z,
so it seems to hang at the height h u / (v + u), with the camera at h. What stands has something below.

So the factor by which it is farther than it seems follows from the lowest of its points, and from the lanes of oncoming
traffic, in which it drives.
"""

import numpy as np
from scipy.sparse.csgraph import connected_components

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.crossing import Crossers
from vpf_sim.perception.obstacles.static_obstacle_settings import OncomingConfig, StaticObstacleConfig
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, Integers, RoadEdges

RATIOS = 12  # of the depths that are tried
LEAST_POINTS = 3  # of a vehicle
LINK_M, LINK_SHARE = 0.8, 0.1  # between its points where they seem to be, across and, of the depth, along
FOOT_M, FOOT_SIGMA = 0.2, 0.35  # height of its lowest point, and the error of a logarithm of the factor by that
LANE_SIGMA_M = 0.6  # of its middle about that of the oncoming lanes
ACROSS_SIGMA_MPS = 0.5


def come_towards(
    points: Triangulation, tall: Integers, road: RoadEdges, camera: Camera, config: StaticObstacleConfig
) -> Bools:
    """(n,) which of the points `tall` (n,), in the own lanes, are of traffic in the lanes of the other direction."""
    oncoming = config.oncoming
    if not road.oncoming_m or not len(tall):
        return np.zeros(len(tall), np.bool_)
    depth, right = points.depth_m[tall], points.right_m[tall]
    sure = (points.chi2 < config.chi2_limit) & (points.sigma_m < config.depth_ratio * points.depth_m)
    low = np.flatnonzero(sure & (points.height_m > oncoming.lowest_m) & (points.height_m < oncoming.hangs_m))
    beside = np.abs(points.right_m[low] - right[:, None]) < oncoming.across_m
    near = np.abs(points.depth_m[low] - depth[:, None]) < oncoming.along_share * depth[:, None]
    hangs = (points.height_m[tall] > oncoming.hangs_m) & ~np.any(beside & near, axis=1)
    return np.asarray(hangs & _before_oncoming_lanes(depth, right, road, camera, oncoming))


def oncoming_vehicles(
    points: Triangulation, rows: Integers, road: RoadEdges, camera: Camera, config: OncomingConfig, own_mps: float
) -> Crossers:
    """The vehicles whose points, by their rows, come towards a car at a speed."""
    depth, right = points.depth_m[rows], points.right_m[rows]
    near = np.abs(right[:, None] - right) < LINK_M
    near &= np.abs(depth[:, None] - depth) < LINK_SHARE * np.minimum(depth[:, None], depth)
    label = connected_components(near)[1] if len(rows) else rows
    found = []
    for one in np.flatnonzero(np.bincount(label) >= LEAST_POINTS).tolist():
        mine = label == one
        seems, bearing = float(np.median(depth[mine])), right[mine] / depth[mine]
        lowest = float(points.height_m[rows[mine]].min())
        ratio, sigma = _ratio(seems, float(bearing.mean()), lowest, road, camera, config)
        farther = seems * ratio
        along = -own_mps * (ratio - 1.0)
        sides = bearing.min() * farther, bearing.max() * farther
        found.append((farther, *sides, 0.0, along, farther * sigma, ACROSS_SIGMA_MPS))
    return Crossers(*np.array(found, float).reshape(-1, 7).T)


def _ratio(
    depth_m: float, bearing: float, lowest_m: float, road: RoadEdges, camera: Camera, config: OncomingConfig
) -> tuple[float, float]:
    """The factor by which a vehicle is farther than it seems, and its standard deviation as a share of it."""
    ratio = np.geomspace(config.nearest_ratio, config.farthest_ratio, 4 * RATIOS)
    by_foot = np.log((camera.height_m - FOOT_M) / max(camera.height_m - lowest_m, FOOT_M))
    left, _ = carriageway_offsets(camera.forward_m + depth_m * ratio, road)
    off_lane = (bearing * depth_m * ratio - (left - 0.5 * road.oncoming_m)) / LANE_SIGMA_M
    weight = np.exp(-0.5 * (off_lane**2 + ((np.log(ratio) - by_foot) / FOOT_SIGMA) ** 2)) + 1e-12
    mean = float(np.average(ratio, weights=weight))
    return mean, float(np.sqrt(np.average((ratio - mean) ** 2, weights=weight))) / mean


def _before_oncoming_lanes(
    depth_m: Floats, right_m: Floats, road: RoadEdges, camera: Camera, config: OncomingConfig
) -> Bools:
    """(n,) whether the line of sight through a point leads on to the lanes of oncoming traffic."""
    ratio = np.geomspace(config.nearest_ratio, config.farthest_ratio, RATIOS)
    left, _ = carriageway_offsets(camera.forward_m + depth_m[:, None] * ratio, road)
    aside = right_m[:, None] * ratio
    return np.asarray(np.any((aside < left) & (aside > left - road.oncoming_m), axis=1))
