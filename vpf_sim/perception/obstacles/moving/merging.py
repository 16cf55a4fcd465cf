"""Tracks of one vehicle, side by side in one lane or one before the other, become one."""

import numpy as np

from vpf_sim.geometry import rotation
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import MergingConfig, MovingObstacleConfig
from vpf_sim.perception.obstacles.moving.track import MovingTrack
from vpf_sim.types import Floats


def merged(tracks: list[MovingTrack], pose: Floats, config: MovingObstacleConfig) -> list[MovingTrack]:
    """The tracks without those that are part of a surer one, which takes over the older identity."""
    merging = config.merging
    if len(tracks) < 2:
        return tracks
    kept: list[MovingTrack] = []
    for track in sorted(tracks, key=lambda track: (-track.log_odds, track.place(pose)[0])):
        same = next((other for other in kept if _is_part(track, other, pose, config, merging)), None)
        if same is None:
            kept.append(track)
        else:
            names = [name for name in (track.identity, same.identity) if name is not None]
            same.identity = min(names, default=None)
    return kept


def _is_part(
    track: MovingTrack, other: MovingTrack, pose: Floats, config: MovingObstacleConfig, merging: MergingConfig
) -> bool:
    apart = np.subtract(track.place(pose), other.place(pose))
    ahead, aside = rotation(pose[2] - other.course.direction_rad) @ apart  # along its course and across
    alike = abs(track.speed_mps - other.speed_mps) < merging.speed_mps
    in_sight = other.depth_m(pose) > config.follow_m
    near = other.half_m + track.half_m + merging.beside_m if in_sight else merging.predicted_m
    return bool(alike and abs(ahead) < config.length_m + in_sight and abs(aside) < near)
