"""How far a path leads: to what stands on it, or on.

The time that a motion covers is too short to show a slow car that its path is closed a few metres farther on.
"""

import numpy as np

from vpf_sim.planning.spacetime.candidates import PathState, Profiles
from vpf_sim.planning.spacetime.motions import AHEAD_M, Motions
from vpf_sim.planning.spacetime.rectangles import Rectangles, gaps
from vpf_sim.scene import Road, Scene, Tracks, predict
from vpf_sim.types import Bools, Reals, VehicleModel

STANDING_MPS = 0.1
EVERY_M = 1.0  # about, along a path
NOW = np.zeros(1)
CREEPING_MPS = 0.4


def way_m(scene: Scene, start: PathState, considered: Motions, vehicle: VehicleModel, quantile: float) -> Reals:
    """(P,) m along the road from the car's front to what stands on each path; inf where nothing does.

    A path meets an object whose rectangle, larger by `quantile` standard deviations of its place, overlaps the car's.
    The way is the same for all paths that meet an object: a car that turns before a wall gets no farther.
    """
    ways = np.full(considered.shape[0], np.inf)
    standing = scene.tracks.select(
        np.flatnonzero((np.abs(scene.tracks.speed_mps) < STANDING_MPS) & (scene.tracks.s_m > start.s_m))
    )
    if not len(standing):
        return ways
    places = np.unique(np.searchsorted(considered.ahead_m, np.arange(0.0, AHEAD_M, EVERY_M)))
    ahead = considered.ahead_m[places]
    car = Rectangles.of_car([values[:, places] for values in considered.poses], vehicle)
    objects = Rectangles.of_tracks(predict(scene.road, standing, NOW), considered.origin_m, quantile)
    near_m = _near_side_m(scene.road, standing) - (start.s_m + vehicle.l_r_m + 0.5 * vehicle.length_m)
    for k in range(len(standing)):
        meets = gaps(car, objects.at(k)).largest < 0.0
        meets &= ~meets[:, :1]  # what may already touch the car closes no way: all paths begin there
        end_m = near_m[k] if near_m[k] > 0.0 else ahead[meets.argmax(axis=1)]  # it begins beside the car
        ways = np.minimum(ways, np.where(meets.any(axis=1), end_m, np.inf))
    return ways


def leads_on(ways_m: Reals, profiles: Profiles) -> Bools:
    """Whether a path leads on from where a motion is then; to its end a car drives, and does not creep.

    (W, M, T) for ways (W,).
    """
    way = ways_m[:, None, None]
    leads: Bools = (profiles.travelled_m < way) & (np.isinf(way) | (profiles.speed_mps > CREEPING_MPS))
    return leads


def _near_side_m(road: Road, tracks: Tracks) -> Reals:
    """(K,) s, m, where objects begin."""
    angle = tracks.heading_rad - road.at(tracks.s_m).heading_rad
    deep = np.abs(np.cos(angle)) * tracks.length_m + np.abs(np.sin(angle)) * tracks.width_m
    near: Reals = tracks.s_m - 0.5 * deep
    return near
