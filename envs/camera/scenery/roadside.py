"""The faces of all road furniture, and the shadows that they cast."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.mesh import Mesh
from vpf_sim.types import Bools, Camera, Floats

VERTICES = 4  # of every face
VISIBLE_PX = 0.5  # faces thinner than this are not drawn
WHOLE_RANGE_M = 1e3  # faces drawn up to this distance are drawn over the whole range of their item
FADING = 0.15  # last share of the range, in which an item fades
COARSE_M = 60.0  # faces drawn at this distance cast shadows; at full detail
EDGE_ON = 0.05  # except faces at grazing sunlight
LOWEST_SUN = 0.1  # lowest sine of the altitude for shadow lengths

Placement = tuple[Mesh, Floats, float]  # mesh, pose (x, y, heading), drawing range m
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Group:
    """Items and their faces in world axes; an item's faces are consecutive, in painter's order."""

    middles_m: Floats  # (k, 2)
    radii_m: Floats  # (k,)
    owner: Indices  # (F,) index of the face's item
    faces_m: Floats  # (F, VERTICES, 3)
    normals: Floats  # (F, 3)
    offsets_m: Floats  # (F,) plane offsets
    colours: Floats  # (F, 3) RGB in full light
    from_m: Floats  # (F,) distance range of the face
    until_m: Floats  # (F,)
    fading: Floats  # (F,) 1/m, slope of the opacity in the last share of the range
    retro: Bools  # (F,) whether they are retroreflective
    lit: Bools  # (F,) whether light shades them


def shadow_polygons(group: Group, light: Light, camera: Camera) -> list[Floats]:
    """(n, 2) m, shadow outlines of furniture on the ground."""
    coarse = (group.until_m >= COARSE_M * detail(camera)) & (np.abs(group.normals @ light.sun) > EDGE_ON)
    faces = group.faces_m[coarse]
    cast = faces[..., :2] - faces[..., 2:] * (light.sun[:2] / max(light.sun[2], LOWEST_SUN))
    return list(cast)


def group_of(items: list[Placement], camera: Camera) -> Group:
    """All faces in world axes."""
    poses = np.array([pose for _, pose, _ in items]).reshape(-1, 3)
    meshes = [mesh for mesh, _, _ in items]
    kinds = {id(mesh): mesh for mesh in meshes}  # most items are of few kinds
    first = dict(zip(kinds, np.cumsum([0, *(len(mesh.faces_m) for mesh in kinds.values())]).tolist(), strict=False))
    counts = np.array([len(mesh.faces_m) for mesh in meshes], np.int64)
    index = np.concatenate(
        [np.empty(0, np.int64), *(np.arange(first[id(mesh)], first[id(mesh)] + len(mesh.faces_m)) for mesh in meshes)]
    )
    owner = np.repeat(np.arange(len(items)), counts)
    c, s = np.cos(poses[owner, 2]), np.sin(poses[owner, 2])
    zero, one = np.zeros(len(owner)), np.ones(len(owner))
    turns = np.stack([c, -s, zero, s, c, zero, zero, zero, one], axis=1).reshape(-1, 3, 3)
    places = np.column_stack([poses[owner, :2], zero])

    def joined(name: str, *shape: int) -> Floats:
        of_kinds = [np.empty((0, *shape)), *(getattr(mesh, name) for mesh in kinds.values())]
        return np.asarray(np.concatenate(of_kinds)[index])

    own = [np.empty((0, VERTICES, 3)), *(mesh.faces_m[:, :VERTICES] for mesh in kinds.values())]
    faces = np.concatenate(own)[index]
    faces = np.einsum("fij,fvj->fvi", turns, faces) + places[:, None]
    normals = np.einsum("fij,fj->fi", turns, joined("normals", 3))
    ranges_m = np.array([range_m for _, _, range_m in items], float)[owner]
    share, until_m = detail(camera), joined("until_m")
    until_m = np.where(until_m < WHOLE_RANGE_M, share * until_m, until_m)
    thinnest = joined("thickness_m") * camera.fx_px / VISIBLE_PX
    return Group(
        middles_m=poses[:, :2],
        radii_m=np.array([mesh.reach_m for mesh in meshes]),
        owner=owner,
        faces_m=faces,
        normals=normals,
        offsets_m=np.einsum("fi,fi->f", normals, faces[:, 0]),
        colours=joined("colours", 3),
        retro=joined("retro") > 0.0,
        lit=joined("lit") > 0.0,
        from_m=joined("from_m") * share,
        until_m=np.minimum(np.minimum(until_m, thinnest), ranges_m),
        fading=1.0 / (FADING * ranges_m),
    )
