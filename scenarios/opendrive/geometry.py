"""The reference line of a road: line, arc, spiral, poly3 and paramPoly3, in OpenDRIVE's axes (y left)."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vpf_sim.errors import InputError, shown
from vpf_sim.scenarios.opendrive.xml_file import Element, number
from vpf_sim.types import Floats

PANELS = 16
NEWTON_STEPS = 30
MOST_TURN_RAD = 100.0  # of a geometry
MOST_STRETCH = 0.1
KINDS = ("line", "arc", "spiral", "poly3", "paramPoly3")
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
    """(...) m, displacement along clothoids that start with heading 0: the integral of exp(i (k v + rate v^2 / 2))."""
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


class Motion(NamedTuple):
    """The reference line at some distances."""

    point: Complexes  # m, x + iy
    heading_rad: Floats
    turn_per_m: Floats  # derivative of the heading by s
    turn_rate_per_m2: Floats  # its derivative


@dataclass(frozen=True, slots=True)
class Clothoid:
    """Curvature is linear in s: a line, an arc or a spiral."""

    s_m: float
    length_m: float
    start: complex
    heading_rad: float
    curvature_per_m: float
    rate_per_m2: float
    stretch: float = 1.0  # metres of the curve for a metre of s

    def at(self, s_m: Floats) -> Motion:
        v = s_m - self.s_m
        k, rate = self.curvature_per_m, self.rate_per_m2
        heading = self.heading_rad + (k + 0.5 * rate * v) * v
        point = self.start + np.exp(1j * self.heading_rad) * displacement(k, rate, v)
        return Motion(point, heading, k + rate * v, np.full(v.shape, rate))


@dataclass(frozen=True, slots=True)
class Polynomial:
    """u(p) and v(p) along and left of the start; s is the distance along the curve, as a share of its length."""

    s_m: float
    length_m: float
    start: complex
    heading_rad: float
    along: np.polynomial.Polynomial
    left: np.polynomial.Polynomial
    end: float  # p of the end
    stretch: float

    def at(self, s_m: Floats) -> Motion:
        p = self._parameter((s_m - self.s_m) * self.stretch)
        first, second, third = (self._derivative(order)(p) for order in (1, 2, 3))
        speed = np.abs(first)
        slope = np.real(np.conj(first) * second) / speed
        turn = np.imag(np.conj(first) * second) / speed**2  # by p
        turn_rate = np.imag(np.conj(first) * third) / speed**2 - 2.0 * slope * turn / speed
        curvature_slope = (turn_rate - turn * slope / speed) / speed  # of the curvature, turn / speed
        direction = complex(math.cos(self.heading_rad), math.sin(self.heading_rad))
        return Motion(
            self.start + direction * self._derivative(0)(p),
            self.heading_rad + np.angle(first),
            self.stretch * turn / speed,
            self.stretch**2 * curvature_slope / speed,
        )

    def _derivative(self, order: int) -> Callable[[Floats], Complexes]:
        along, left = self.along.deriv(order), self.left.deriv(order)
        return lambda p: np.asarray(along(p) + 1j * left(p))

    def _parameter(self, distance_m: Floats) -> Floats:
        """p at distances along the curve, by Newton's method."""
        p = distance_m / (self.stretch * self.length_m) * self.end
        for _ in range(NEWTON_STEPS):
            excess = _arc_length(self.along, self.left, p) - distance_m
            step = excess / np.abs(self._derivative(1)(p))
            p = p - step
            if np.max(np.abs(step), initial=0.0) <= 1e-13 * self.end:
                break
        return np.asarray(p)


Geometry = Clothoid | Polynomial


def _arc_length(along: np.polynomial.Polynomial, left: np.polynomial.Polynomial, p: Floats) -> Floats:
    """Metres along a polynomial curve from 0 to each p."""
    nodes, weights = on_panels(PANELS)
    at = p[..., None] * nodes
    return np.asarray(p * (np.hypot(along.deriv()(at), left.deriv()(at)) @ weights))


def read_geometry(element: Element, where: str) -> Geometry:
    """A `<geometry>` of a plan view."""
    s_m, length_m, x, y, heading = (number(element, key, where) for key in ("s", "length", "x", "y", "hdg"))
    start = complex(x, y)
    shape = next((child for child in element if child.tag in KINDS), None)
    if shape is None:
        tags = shown(", ".join(child.tag for child in element)) if len(element) else "none"
        raise InputError(f"{where}: expected one of {', '.join(KINDS)}, got {tags}")
    where = f"{where}.{shape.tag}"
    if shape.tag == "poly3":
        left = np.polynomial.Polynomial([number(shape, key, where) for key in "abcd"])
        return _with_own_length(s_m, length_m, start, heading, left)
    if shape.tag == "paramPoly3":
        along, left = (np.polynomial.Polynomial([number(shape, key + axis, where) for key in "abcd"]) for axis in "UV")
        end = length_m if shape.get("pRange") == "arcLength" else 1.0
        stretch = float(_arc_length(along, left, np.array(end))) / length_m
        if not abs(stretch - 1.0) <= MOST_STRETCH:
            raise InputError(
                f"{where}: expected a curve of its geometry's length {length_m:g} m, got {stretch * length_m:g} m"
            )
        return Polynomial(s_m, length_m, start, heading, along, left, end, stretch)
    first, last = 0.0, 0.0
    if shape.tag == "arc":
        first = last = number(shape, "curvature", where)
    if shape.tag == "spiral":
        first, last = number(shape, "curvStart", where), number(shape, "curvEnd", where)
    if max(abs(first), abs(last)) * length_m > MOST_TURN_RAD:
        raise InputError(
            f"{where}: expected a turn of up to {MOST_TURN_RAD:g} rad, got curvatures of {first:g} and {last:g} 1/m"
        )
    return Clothoid(s_m, length_m, start, heading, first, (last - first) / length_m)


def _with_own_length(
    s_m: float, length_m: float, start: complex, heading: float, left: np.polynomial.Polynomial
) -> Polynomial:
    """A poly3: v(u), as long as the geometry."""
    along = np.polynomial.Polynomial([0.0, 1.0])
    end = length_m / math.hypot(1.0, left.coef[1])
    for _ in range(NEWTON_STEPS):
        slope = math.hypot(1.0, float(left.deriv()(end)))
        end -= (float(_arc_length(along, left, np.array(end))) - length_m) / slope
    return Polynomial(s_m, length_m, start, heading, along, left, end, 1.0)
