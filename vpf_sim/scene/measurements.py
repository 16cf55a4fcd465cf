"""Detections for the tracker, from what perception reports."""

from math import cos, sin

import numpy as np

from vpf_sim.perception.object_sizes import ObjectSizes
from vpf_sim.scene.road import Road
from vpf_sim.scene.tracker import Detections
from vpf_sim.types import Floats, Obstacles

ALONG_SIGMA_M, ACROSS_SIGMA_M, MOVING_ACROSS_SIGMA_M = 0.2, 0.12, 0.25  # at least
STANDING_SIGMA_MPS, MOVING_SIGMA_MPS = 0.05, 0.5
CONFIRMED = 4.0  # log-odds that an obstacle adds which perception has confirmed by itself


def of_obstacles(obstacles: Obstacles, pose: Floats, road: Road, s_m: float, sizes: ObjectSizes) -> Detections:
    """Obstacles in the axes of a car at a pose (x m, y m, yaw rad), `s_m` along the road; lengths by class."""
    count = len(obstacles)
    cosine, sine = cos(pose[2]), sin(pose[2])
    x = pose[0] + cosine * obstacles.forward_m - sine * obstacles.middle_m
    y = pose[1] + sine * obstacles.forward_m + cosine * obstacles.middle_m
    s, d = road.place_at(x, y, s_m + obstacles.forward_m)
    moving = obstacles.speed_mps != 0.0
    sigma = np.empty((count, 4))
    sigma[:, 0] = np.clip(obstacles.sigma_m, ALONG_SIGMA_M, 2.0)
    sigma[:, 1] = np.where(moving, MOVING_ACROSS_SIGMA_M, ACROSS_SIGMA_M)
    sigma[:, 2:] = np.where(moving, MOVING_SIGMA_MPS, STANDING_SIGMA_MPS)[:, None]
    covariance = np.eye(4) * (sigma**2)[:, None, :]
    state = np.stack([s, d, obstacles.speed_mps, np.zeros(count)], axis=1)
    width = obstacles.width_m
    return Detections(state, covariance, sizes.lengths_m(width), width, np.full(count, CONFIRMED))
