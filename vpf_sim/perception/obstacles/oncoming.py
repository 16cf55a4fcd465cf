"""Points of oncoming traffic, which look as if they stood nearer and hung in the air.

A vehicle at the depth Z that comes at u towards a car at v is triangulated as if it stood, at Z v / (v + u): the time
to contact is right, the place is not, and no motion of its image tells the two apart. But its foot is on the road at Z,
so it seems to hang at the height h u / (v + u), with the camera at h. What stands has something below.
"""

import numpy as np

from vpf_sim.perception.egomotion.triangulation import Triangulation
from vpf_sim.perception.obstacles.config import OncomingConfig
from vpf_sim.perception.road.geometry import carriageway_offsets
from vpf_sim.types import Bools, Camera, Integers, RoadEdges


def come_towards(
    points: Triangulation, tall: Integers, above: Integers, road: RoadEdges, camera: Camera, config: OncomingConfig
) -> Bools:
    """(n,) which of the points `tall` (n,), in the own lanes, hang above nothing before the lanes of oncoming traffic.

    `above` (m,) are the points that may be what stands below them.
    """
    depth, right, height = points.depth_m[tall], points.right_m[tall], points.height_m[tall]
    ratio = np.array(config.farther)
    left, _ = carriageway_offsets(camera.forward_m + depth[:, None] * ratio, road)
    aside = right[:, None] * ratio
    before = ((aside < left) & (aside > left - road.oncoming_m)).any(axis=1)
    low = above[points.height_m[above] < config.hangs_m]
    below = np.abs(points.right_m[low] - right[:, None]) < config.across_m
    below &= np.abs(points.depth_m[low] - depth[:, None]) < config.along_share * depth[:, None]
    hangs: Bools = (height > config.hangs_m) & before & ~below.any(axis=1)
    return hangs
