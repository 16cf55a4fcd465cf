"""Structure tensors of tracked points: on a corner Lucas-Kanade is well posed, along an edge it slides."""

import numpy as np

from vpf_sim.types import Bools, Floats, Image


def structure_tensor(image: Image, points_px: Floats, window_px: int) -> Floats:
    """(N, 2, 2) mean of grad I grad I^T over the window about each point, grey levels^2 / px^2 (Shi-Tomasi).

    At the frame's edge the window is the nearest that lies inside.
    """
    size = window_px + 2
    height, width = image.shape
    corner = np.rint(points_px).astype(np.intp) - size // 2
    corner = np.minimum(np.maximum(corner, 0), (width - size, height - size))
    image = np.ascontiguousarray(image)
    # Every window of the image, by the row and column of its corner, without a copy.
    shape = (height - size + 1, width - size + 1, size, size)
    windows: Image = np.ndarray(shape, image.dtype, image, strides=2 * image.strides)
    patch = windows[corner[:, 1], corner[:, 0]].astype(np.float32)
    across = patch[:, 1:-1, 2:] - patch[:, 1:-1, :-2]
    down = patch[:, 2:, 1:-1] - patch[:, :-2, 1:-1]
    tensor = np.empty((len(patch), 2, 2))
    tensor[:, 0, 0] = np.einsum("nij,nij->n", across, across)  # of whole numbers: exact in any order below 2^24
    tensor[:, 1, 1] = np.einsum("nij,nij->n", down, down)
    tensor[:, 0, 1] = tensor[:, 1, 0] = np.einsum("nij,nij->n", across, down)
    tensor /= 4 * window_px**2
    return tensor


def inverse(matrices: Floats) -> Floats:
    """(N, 2, 2) inverses of symmetric matrices (N, 2, 2)."""
    a, b, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    result = np.empty_like(matrices)
    result[:, 0, 0], result[:, 1, 1] = d, a
    result[:, 0, 1] = result[:, 1, 0] = -b
    result /= (a * d - b * b)[:, None, None]
    return result


def eigenvalues(structure: Floats) -> tuple[Floats, Floats]:
    """(N,) small and (N,) large ones, grey levels^2 / px^2, of symmetric structure tensors (N, 2, 2).

    Shi and Tomasi (1994), doi 10.1109/CVPR.1994.323794.
    """
    a, b, d = structure[:, 0, 0], structure[:, 0, 1], structure[:, 1, 1]
    mean, half = 0.5 * (a + d), np.hypot(0.5 * (a - d), b)
    return mean - half, mean + half


def is_corner(structure: Floats, least: float, ratio: float) -> Bools:
    """(N,) tensors (N, 2, 2) with a small eigenvalue above `least` that is no less than that share of the large one."""
    small, large = eigenvalues(structure)
    clear: Bools = (small > least) & (small > ratio * large)
    return clear
