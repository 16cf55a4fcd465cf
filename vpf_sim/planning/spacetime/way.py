"""How far a path leads: to what stands on it, or on.

The time that a motion covers is too short to show a slow car that its path is closed a few metres farther on.
"""

import numpy as np

from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.planning.spacetime.motions import motions
from vpf_sim.planning.spacetime.obstacles import Body, gaps
from vpf_sim.scene import Road, Scene, Tracks, predict
from vpf_sim.types import Bools, Reals, VehicleModel

STANDING_MPS = 0.1
AHEAD_M, EVERY_M = 20.0, 1.0  # of a path
NOW = np.zeros(1)
CREEPING_MPS = 0.4


def way_m(scene: Scene, start: PathState, paths: Paths, vehicle: VehicleModel, quantile: float) -> Reals:
    """(P,) m along the road from the car's front to what stands on each path; inf where nothing does.

    A path meets an object whose rectangle, larger by `quantile` standard deviations of its place, overlaps the car's.
    The way is the same for all paths that meet an object: a car that turns before a wall gets no farther.
    """
    ways = np.full(len(paths.start_m), np.inf)
    standing = scene.tracks.select(
        np.flatnonzero((np.abs(scene.tracks.speed_mps) < STANDING_MPS) & (scene.tracks.s_m > start.s_m))
    )
    if not len(standing):
        return ways
    ahead = np.arange(0.0, AHEAD_M, EVERY_M)
    still = np.zeros((1, len(ahead)))
    along = motions(scene.road, start, paths, Profiles(ahead[None], still, still), vehicle)
    body, now = Body.of(along, np.arange(len(ways)), vehicle), predict(scene.road, standing, NOW)
    near_m = _near_side_m(scene.road, standing) - (start.s_m + vehicle.l_r_m + 0.5 * vehicle.length_m)
    for k in range(len(standing)):
        gap = gaps(body, now, k, along.origin_m, quantile)
        meets = gap.largest < 0.0
        meets &= ~meets[:, :1]  # what may already touch the car closes no way: all paths begin there
        end_m = near_m[k] if near_m[k] > 0.0 else ahead[meets.argmax(axis=1)]  # it begins beside the car
        ways = np.minimum(ways, np.where(meets.any(axis=1), end_m, np.inf))
    return ways


def leads_on(ways_m: Reals, profiles: Profiles) -> Bools:
    """Whether a path leads on from where a motion is then; to its end a car drives, and does not creep.

    (P, M, T), or (1, 1, 1) where all ways are free.
    """
    if np.isinf(ways_m).all():
        return np.ones((1, 1, 1), bool)
    way = ways_m[:, None, None]
    leads: Bools = (profiles.travelled_m < way) & (np.isinf(way) | (profiles.speed_mps > CREEPING_MPS))
    return leads


def _near_side_m(road: Road, tracks: Tracks) -> Reals:
    """(K,) s, m, where objects begin."""
    angle = tracks.heading_rad - road.at(tracks.s_m).heading_rad
    deep = np.abs(np.cos(angle)) * tracks.length_m + np.abs(np.sin(angle)) * tracks.width_m
    near: Reals = tracks.s_m - 0.5 * deep
    return near
