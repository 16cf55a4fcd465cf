"""Splits the faces of objects into level bands, so that the low beam's cut-off shows on them."""

from dataclasses import replace

import numpy as np

from vpf_sim.envs.camera.scenery.mesh import Mesh
from vpf_sim.envs.camera.view import clip_near
from vpf_sim.types import Floats

HEIGHTS_M = (0.3, 0.5, 0.65, 0.9, 1.4)  # the cut-off is 0.65 m high at the car, and 1 cm lower with each metre
LEAST_M = 0.2  # lower faces stay whole
UPSIDE_DOWN = np.array([1.0, 1.0, -1.0])


def banded(mesh: Mesh) -> Mesh:
    """The mesh with its taller faces cut at HEIGHTS_M; what it covers stays the same."""
    faces, owners = mesh.faces_m, np.arange(len(mesh.faces_m))
    for height in HEIGHTS_M:
        low, high = faces[..., 2].min(axis=1), faces[..., 2].max(axis=1)
        cut = (low < height - 0.01) & (high > height + 0.01) & (high - low > LEAST_M)
        if not cut.any():
            continue
        below = _above(faces[cut] * UPSIDE_DOWN, -height) * UPSIDE_DOWN
        parts = [faces[~cut], below, _above(faces[cut], height)]
        corners = max(part.shape[1] for part in parts)
        faces = np.concatenate([_padded(part, corners) for part in parts])
        owners = np.concatenate([owners[~cut], owners[cut], owners[cut]])
    order = np.argsort(owners, kind="stable")
    own = owners[order]
    return replace(
        mesh,
        faces_m=faces[order],
        normals=mesh.normals[own],
        colours=mesh.colours[own],
        lit=mesh.lit[own],
        retro=mesh.retro[own],
        parts=mesh.parts[own],
        thickness_m=mesh.thickness_m[own],
        from_m=mesh.from_m[own],
        until_m=mesh.until_m[own],
    )


def _above(faces: Floats, height: float) -> Floats:
    """(n, W, 3) the parts of faces (n, V, 3) above a height."""
    return clip_near(faces, faces[..., 2] > height, height)


def _padded(faces: Floats, corners: int) -> Floats:
    """The faces with their last vertex repeated up to `corners` of them."""
    return np.concatenate([faces, faces[:, -1:].repeat(corners - faces.shape[1], axis=1)], axis=1)
