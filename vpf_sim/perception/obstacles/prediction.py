"""Obstacles at another pose of the vehicle, and later."""

from dataclasses import replace

import numpy as np

from vpf_sim.geometry import vehicle_from_world, world_from_vehicle
from vpf_sim.perception.road.geometry import direction_rad
from vpf_sim.types import Floats, Obstacles, RoadEdges


def none() -> Obstacles:
    empty = np.empty(0)
    return Obstacles(empty, empty, empty, empty, empty, np.empty(0, np.int64))


def to_current_frame(obstacles: Obstacles, before: Floats, pose: Floats) -> Obstacles:
    """Obstacles of the vehicle at the pose `before`, in its axes at `pose`, as if none had moved since."""
    if not len(obstacles):
        return obstacles
    middle = obstacles.middle_m
    place = np.stack([obstacles.forward_m, middle], axis=1)
    place = vehicle_from_world(world_from_vehicle(place, before), pose)
    aside = place[:, 1] - middle
    left, right = obstacles.left_m + aside, obstacles.right_m + aside
    return replace(obstacles, forward_m=place[:, 0], left_m=left, right_m=right)


def predict(obstacles: Obstacles, before: Floats, pose: Floats, road: RoadEdges, since_s: float) -> Obstacles:
    """Obstacles of the pose `before` in the axes at `pose`, moved along the road for the time since."""
    if obstacles.speed_mps.any():
        travel, angle = obstacles.speed_mps * since_s, direction_rad(obstacles.forward_m, road)
        forward, aside = np.cos(angle) * travel, np.sin(angle) * travel
        obstacles = replace(
            obstacles,
            forward_m=obstacles.forward_m + forward,
            left_m=obstacles.left_m + aside,
            right_m=obstacles.right_m + aside,
        )
    return to_current_frame(obstacles, before, pose)
