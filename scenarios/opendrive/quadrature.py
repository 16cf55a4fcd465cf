"""Integrals by Gauss-Legendre quadrature, exact to rounding for the curves of roads."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vpf_sim.types import Floats

Complexes = NDArray[np.complex128]  # points and vectors, x + iy
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
NODES: Floats = (1.0 + _NODES) / 2.0  # on [0, 1]
WEIGHTS: Floats = _WEIGHTS / 2.0
PANEL_TURN_RAD = 0.5


def on_panels(panels: int) -> tuple[Floats, Floats]:
    """Nodes and weights on [0, 1], divided into panels of 8 nodes."""
    nodes = (np.arange(panels)[:, None] + NODES).ravel() / panels
    return nodes, np.tile(WEIGHTS, panels) / panels


def displacement(curvature: ArrayLike, rate: ArrayLike, distance_m: ArrayLike) -> Complexes:
    """(...) m, way along clothoids that start with heading 0: the integral of exp(i (k v + rate v^2 / 2))."""
    k, c, v = np.broadcast_arrays(*(np.asarray(one, float)[..., None] for one in (curvature, rate, distance_m)))
    turn = np.max(np.abs(k * v) + 0.5 * np.abs(c) * v**2, initial=0.0)
    nodes, weights = on_panels(max(1, math.ceil(turn / PANEL_TURN_RAD)))
    at = v * nodes
    return np.asarray(v[..., 0] * (np.exp(1j * (k + 0.5 * c * at) * at) @ weights))
