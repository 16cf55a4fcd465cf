"""How far a path leads: to what stands on it, or on.

The time that a motion covers is too short to show a slow car that its path is closed a few metres farther on.
"""

import numpy as np

from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.planning.spacetime.motions import motions
from vpf_sim.planning.spacetime.obstacles import Body, gaps
from vpf_sim.scene import Scene, predict
from vpf_sim.types import Reals, VehicleModel

STANDING_MPS = 0.1
AHEAD_M, EVERY_M = 20.0, 1.0  # of a path
NOW = np.zeros(1)


def way_m(scene: Scene, start: PathState, paths: Paths, vehicle: VehicleModel, quantile: float) -> Reals:
    """(P,) m along the road until the car, on each path, meets what stands there; inf where nothing does.

    Objects are larger by `quantile` standard deviations of their place.
    """
    ways = np.full(len(paths.start_m), np.inf)
    standing = scene.tracks.select(np.flatnonzero(scene.tracks.speed_mps < STANDING_MPS))
    if not len(standing):
        return ways
    ahead = np.arange(0.0, AHEAD_M, EVERY_M)
    still = np.zeros((1, len(ahead)))
    along = motions(scene.road, start, paths, Profiles(ahead[None], still, still), vehicle)
    body, now = Body.of(along, np.arange(len(ways)), vehicle), predict(scene.road, standing, NOW)
    for k in range(len(standing)):
        gap = gaps(body, now, k, along.origin_m, quantile)
        meets = np.maximum.reduce([gap.along, gap.across, gap.object_along, gap.object_across]) < 0.0
        meets &= ~meets[:, :1]  # what may already touch the car closes no way: all paths begin there
        ways = np.minimum(ways, np.where(meets.any(axis=1), ahead[meets.argmax(axis=1)], np.inf))
    return ways
