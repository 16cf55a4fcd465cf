"""What each kind of body looks like: a mesh for its kind, its size and a seed."""

import numpy as np

from vpf_sim.envs.camera.mesh import Mesh, MeshBuilder, box

HEIGHTS_M = {"car": 1.5, "van": 2.3, "truck": 3.4, "cone": 0.75, "pallet": 0.15, "barrier": 1.0, "pedestrian": 1.75}


def body_mesh(kind: str, length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    builder = MeshBuilder()
    colour = tuple(float(c) for c in rng.uniform(60, 220, 3))
    panels = box(builder, (-length / 2, -width / 2, 0.2), (length / 2, width / 2, height), colour)
    rear = panels["rear"]
    builder.detail(rear, (0.1, 0.55), (0.9, 0.9), (30, 36, 42))
    builder.detail(rear, (0.03, 0.35), (0.2, 0.5), (190, 20, 20))
    builder.detail(rear, (0.8, 0.35), (0.97, 0.5), (190, 20, 20))
    builder.detail(rear, (0.38, 0.2), (0.62, 0.32), (230, 230, 225))
    return builder.build()
