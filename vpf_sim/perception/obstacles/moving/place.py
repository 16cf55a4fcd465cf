"""Where a track is on the road and which points of the image lie in its outline."""

import numpy as np

from vpf_sim.perception.obstacles.moving.detection import MeasuredPoints
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import MovingObstacleConfig
from vpf_sim.perception.obstacles.moving.track import MovingTrack
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Floats, RoadEdges


def is_on_carriageway(forward_m: float, right_m: float, road: RoadEdges, inside_m: float) -> bool:
    """Whether a place, vehicle axes, is at least `inside_m` inside the edges of the carriageway."""
    left, right = carriageway_offsets(np.array([forward_m]), road)
    return bool(left[0] + inside_m < right_m < right[0] - inside_m)


def in_outline(
    track: MovingTrack,
    seen: MeasuredPoints,
    pose: Floats,
    margin_m: float,
    camera: Camera,
    config: MovingObstacleConfig,
) -> Bools:
    """(N,) points in the outline of a track, or within a margin beside it."""
    forward, right = track.place(pose)
    depth = forward - camera.forward_m
    near, far = max(depth, config.filter.nearest_m), depth + config.length_m
    margin = margin_m + config.margin_ratio * near
    left, right = right - track.half_m - margin, right + track.half_m + margin
    overlaps_us = depth < near and left < 0.0 < right  # the track is wrong, and would hide all
    if far < near or overlaps_us:
        return np.zeros(len(seen.drop), np.bool_)
    inside: Bools = (seen.bearing > min(left / near, left / far)) & (seen.bearing < max(right / near, right / far))
    below = seen.drop * near
    inside &= below > camera.height_m - config.tallest_m
    inside &= below < config.below_road * camera.height_m
    return inside
