"""Cubic polynomials of the distance, and lists of them that follow each other."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vpf_sim.scenarios.opendrive.xml_file import Element, number
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


@dataclass(frozen=True, slots=True)
class Cubic:
    """a + b u + c u^2 + d u^3, at u metres from `s_m`."""

    s_m: float
    a: float
    b: float = 0.0
    c: float = 0.0
    d: float = 0.0

    def at(self, s_m: Floats) -> tuple[Floats, Floats, Floats]:
        """The value and its first and second derivative at each s."""
        u = s_m - self.s_m
        value = self.a + u * (self.b + u * (self.c + u * self.d))
        return value, self.b + u * (2.0 * self.c + u * 3.0 * self.d), 2.0 * self.c + 6.0 * self.d * u

    def plus(self, other: "Cubic", factor: float) -> "Cubic":
        """This one and `factor` times the other."""
        u = self.s_m - other.s_m
        a = other.a + u * (other.b + u * (other.c + u * other.d))
        b = other.b + u * (2.0 * other.c + u * 3.0 * other.d)
        c = other.c + 3.0 * other.d * u
        return Cubic(self.s_m, self.a + factor * a, self.b + factor * b, self.c + factor * c, self.d + factor * other.d)


def read_cubics(elements: Sequence[Element], start_key: str, where: str, start_m: float = 0.0) -> list[Cubic]:
    """The polynomials of elements that begin at their `start_key` after `start_m`, in order."""
    found = [
        Cubic(start_m + number(one, start_key, where, 0.0), *(number(one, key, where, 0.0) for key in "abcd"))
        for one in elements
    ]
    return sorted(found, key=lambda cubic: cubic.s_m)


def valid_at(cubics: Sequence[Cubic], s_m: float) -> Cubic:
    """The last of a list that begins at or before s; the first before all, and zero if there is none."""
    if not cubics:
        return Cubic(0.0, 0.0)
    return cubics[max(0, bisect_right([one.s_m for one in cubics], s_m) - 1)]
