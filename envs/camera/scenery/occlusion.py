"""Drawing order of objects by occlusion."""

import numpy as np

from vpf_sim.types import Bools, Floats


def far_to_near(corners: Floats, eye: Floats) -> list[int]:
    """Drawing order of upright boxes with (n, 4, 2) footprints, from the camera at `eye` (2,).

    An edge separates two disjoint footprints; the one on the camera's side of it is in front.
    """
    middles = corners.mean(axis=1)
    distance = np.hypot(*(middles - eye).T)
    left: list[int] = np.argsort(-distance, kind="stable").tolist()
    if not _overlap(corners - eye, middles - eye):
        return left
    in_front = _in_front(corners, eye)
    order = []
    while left:
        free = next((i for i in left if not any(in_front[i, j] for j in left if j != i)), left[0])
        order.append(free)
        left.remove(free)
    return order


def _overlap(corners: Floats, middles: Floats) -> bool:
    """Whether any two footprints, relative to the camera, overlap in bearing."""
    across = corners[..., 1] * middles[:, None, 0] - corners[..., 0] * middles[:, None, 1]
    along = np.einsum("ncd,nd->nc", corners, middles)
    half = np.arctan2(np.abs(across), along).max(axis=1)
    bearing = np.arctan2(middles[:, 1], middles[:, 0])
    apart = np.abs((bearing[:, None] - bearing + np.pi) % (2.0 * np.pi) - np.pi)
    return int((apart < half[:, None] + half).sum()) > len(corners)


def _in_front(corners: Floats, eye: Floats) -> Bools:
    """(n, n) whether i is in front of j by a separating edge of either."""
    edges = np.roll(corners, -1, axis=1) - corners
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
    inward = np.einsum("ned,nd->ne", normals, corners.mean(axis=1)) > np.einsum("ned,ned->ne", normals, corners)
    normals = np.where(inward[..., None], -normals, normals)
    offsets = np.einsum("ned,ned->ne", normals, corners)
    eye_outside = normals @ eye > offsets + 1e-9
    beyond = (np.einsum("ned,jcd->nejc", normals, corners) >= offsets[..., None, None] - 1e-6).all(axis=3)
    other_in_front = (beyond & eye_outside[..., None]).any(axis=1)
    self_in_front = (beyond & ~eye_outside[..., None]).any(axis=1)
    return np.asarray(self_in_front | other_in_front.T)
