"""Static scenery beside the road, placed by a seed: furniture, trees and bushes."""

import numpy as np

from vpf_sim.envs.camera.layout import Geometry, LaneShape
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery import roadside, trees
from vpf_sim.envs.camera.scenery.trees import BUSHES, HEIGHTS_M, VARIANTS, Trees
from vpf_sim.envs.camera.scenery.verge import STATION_M, Verge
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

TREE_EVERY = 2  # stations between trees, on either side
TREE_SHARE, BUSH_SHARE = 0.8, 0.3
TREE_FREE_M = 4.0  # free radius around a tree


class StaticScenery:
    """The static scenery of one road."""

    def __init__(self, camera: Camera, shapes: list[LaneShape], seed: int) -> None:
        verge = Verge.of(Geometry(shapes))
        self._camera = camera
        self.furniture = verge.furniture(stream(seed, "scenery"))
        self.trees = planted(verge, stream(seed, "trees"))

    def shadow_polygons(self, light: Light) -> list[Floats]:
        """(n, 2) m, shadow outlines on the ground of furniture, trees and bushes."""
        furniture = roadside.shadow_polygons(roadside.group_of(self.furniture, self._camera), light, self._camera)
        return [*furniture, *trees.shadow_polygons(self.trees, light)]


def planted(verge: Verge, rng: np.random.Generator) -> Trees:
    """Trees 6 to 32 m outside the edges, denser near them."""
    feet = [np.empty((0, 2))]
    for side in verge.sides:
        base, out = side.points_m[::TREE_EVERY], side.outward[::TREE_EVERY]
        reach = 5.5 + 26.0 * rng.random(len(base)) ** 1.6
        place = base + reach[:, None] * out + rng.uniform(-STATION_M, STATION_M, (len(base), 2))
        feet.append(place[verge.clear(place, TREE_FREE_M) & (rng.random(len(base)) < TREE_SHARE)])
    all_feet = np.concatenate(feet)
    bushes = rng.random(len(all_feet)) < BUSH_SHARE
    variants = np.where(
        bushes,
        rng.integers(VARIANTS - BUSHES, VARIANTS, len(all_feet)),
        rng.integers(0, VARIANTS - BUSHES, len(all_feet)),
    )
    tall = np.array(HEIGHTS_M)[variants] * rng.uniform(0.75, 1.25, len(all_feet))
    return Trees(all_feet, tall, variants)
