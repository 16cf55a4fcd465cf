"""Bounds of what the scene takes from perception and sensors, beyond any road: all that follows stays finite."""

from dataclasses import replace

import numpy as np

from vpf_sim.geometry import bounded
from vpf_sim.types import Obstacles, RoadEdges

FAR_M, ASIDE_M = 300.0, 100.0  # along and across the road
SHARPEST_PER_M, TURNED_RAD = 1.0, 4.0


def plausible_road(road: RoadEdges) -> RoadEdges:
    """The edges, with values that no road has replaced by the nearest that one may have."""
    return replace(
        road,
        left_m=bounded(road.left_m, ASIDE_M),
        right_m=bounded(road.right_m, ASIDE_M),
        heading_rad=bounded(road.heading_rad, TURNED_RAD),
        curvature_per_m=bounded(road.curvature_per_m, SHARPEST_PER_M),
        lane_m=bounded(road.lane_m, ASIDE_M),
        oncoming_m=bounded(road.oncoming_m, ASIDE_M),
    )


def plausible_obstacles(obstacles: Obstacles) -> Obstacles:
    """The obstacles, those beyond the bounds on them."""
    forward = np.clip(obstacles.forward_m, -FAR_M, FAR_M)
    left, right = (np.clip(side, -ASIDE_M, ASIDE_M) for side in (obstacles.left_m, obstacles.right_m))
    return replace(obstacles, forward_m=forward, left_m=left, right_m=right)
