"""Everything that rises from the ground as content of the core: furniture, trees, objects, their light."""

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.mesh import Mesh
from vpf_sim.envs.camera.scenery.roadside import Group

TRANSMISSION_STEP_M, FARTHEST_M = 0.25, 260.0
NO_SUN = 0.97  # shadows with more remaining brightness are left out
LOWEST_SUN = 0.05  # lowest sine of the altitude for shadow lengths
LIT, RETRO = 1, 2  # flags of a face


def set_light(core: Core, light: Light, haze: Haze) -> None:
    """Set light and haze."""
    fall = -light.sun[:2] / max(float(light.sun[2]), LOWEST_SUN)
    transmission = haze.transmission(np.arange(0.0, FARTHEST_M, TRANSMISSION_STEP_M) + 0.5 * TRANSMISSION_STEP_M)
    core.set_light(
        light.horizon, light.sun, (light.sky, light.direct), (light.contact, light.shadow), fall, transmission
    )


def set_roadside(core: Core, group: Group) -> None:
    """Set the furniture beside the road."""
    first = np.searchsorted(group.owner, np.arange(len(group.radii_m) + 1))
    faces = group.faces_m, group.normals, group.colours, _flags(group.lit, group.retro)
    items = first, group.middles_m, group.radii_m
    core.set_roadside(faces, items, (group.from_m, np.minimum(group.until_m, 1e4), group.fading))


def add_mesh(core: Core, mesh: Mesh, size_m: tuple[float, float, float]) -> int:
    """Add an object's mesh and return its number."""
    faces = mesh.faces_m, mesh.normals, mesh.colours, _flags(mesh.lit, mesh.retro)
    return core.add_mesh(size_m, faces, mesh.parts, mesh.thickness_m, mesh.centres_m)


def _flags(lit: NDArray[np.bool_], retro: NDArray[np.bool_]) -> NDArray[np.uint8]:
    return np.asarray(LIT * lit.astype(np.uint8) + RETRO * retro.astype(np.uint8), np.uint8)
