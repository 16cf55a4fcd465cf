"""The exact centre line of a carriageway: lines, arcs and clothoids, extended straight beyond both ends.

A point of the road is (s, lateral): metres along the centre line, and metres right of it. A piece has at its middle a
pose, a curvature k (> 0 turns right) and a curvature rate c. At v metres from the middle

    heading(v) = heading + k v + c v^2 / 2.

Lines and arcs (c = 0) are closed forms: the chord of an arc is 2 sin(k v / 2) / k. Clothoids are integrated by
Gauss-Legendre quadrature over pieces that turn by at most half a radian, where eight nodes leave rounding errors only.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from vpf_sim.scenarios.parts import Arc, Line, Road, Segment
from vpf_sim.types import Floats


class ReferenceLine(Protocol):
    """A smooth line, extended straight beyond both ends; methods with the suffix `_at` take single points."""

    length_m: float

    def position(self, s_m: ArrayLike, lateral_m: ArrayLike = 0.0) -> Floats:
        """(..., 2) m, the world points at s along the line and `lateral` right of it."""
        ...

    def heading(self, s_m: ArrayLike) -> Floats:
        """(...) rad."""
        ...

    def curvature(self, s_m: ArrayLike) -> Floats:
        """(...) 1/m, > 0 turns right; 0 beyond both ends."""
        ...

    def position_at(self, s_m: float, lateral_m: float) -> tuple[float, float]:
        """`position` of one point."""
        ...

    def heading_at(self, s_m: float) -> float:
        """`heading` at one s."""
        ...


NODES, WEIGHTS = (values.tolist() for values in np.polynomial.legendre.leggauss(8))
QUADRATURE = [((1.0 + node) / 2.0, weight / 2.0) for node, weight in zip(NODES, WEIGHTS, strict=True)]  # on [0, 1]
PIECE_TURN_RAD = 0.5
TIE_M = 1e-9  # tie break at joints: a foot point inside a piece wins over a piece's end


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of constant curvature rate, for `low` <= v <= `high` metres from its middle at `s_m`."""

    s_m: float
    x_m: float
    y_m: float
    heading_rad: float
    curvature_per_m: float
    rate_per_m2: float
    low_m: float
    high_m: float

    def heading(self, v: Any) -> Any:
        """The heading v metres from the middle; a float or an array."""
        return self.heading_rad + (self.curvature_per_m + 0.5 * self.rate_per_m2 * v) * v

    def point(self, v: Any, functions: Any = math) -> tuple[Any, Any]:
        """The point v metres from the middle; a float, or an array with `functions` = numpy."""
        cos, sin = functions.cos, functions.sin
        if self.rate_per_m2 == 0.0:
            half_turn = 0.5 * self.curvature_per_m * v
            chord = v if self.curvature_per_m == 0.0 else 2.0 * sin(half_turn) / self.curvature_per_m
            direction = self.heading_rad + half_turn
            return self.x_m + chord * cos(direction), self.y_m + chord * sin(direction)
        x = y = 0.0
        for node, weight in QUADRATURE:
            direction = self.heading(node * v)
            x = x + weight * cos(direction)
            y = y + weight * sin(direction)
        return self.x_m + v * x, self.y_m + v * y

    def nearest(self, x_m: float, y_m: float) -> float:
        """The v in [low, high] of the point nearest to (x, y): closed form, and Newton's method on a clothoid."""
        k = self.curvature_per_m
        cosine, sine = math.cos(self.heading_rad), math.sin(self.heading_rad)
        along = cosine * (x_m - self.x_m) + sine * (y_m - self.y_m)
        right = cosine * (y_m - self.y_m) - sine * (x_m - self.x_m)
        v = along if k == 0.0 else math.atan2(k * along, 1.0 - k * right) / k
        v = min(max(v, self.low_m), self.high_m)
        return v if self.rate_per_m2 == 0.0 else self._newton(v, x_m, y_m)

    def _newton(self, v: float, x_m: float, y_m: float) -> float:
        """Refine v until the point's offset is perpendicular to the piece, or v reaches an end."""
        for _ in range(20):
            x, y = self.point(v)
            heading = self.heading(v)
            cosine, sine = math.cos(heading), math.sin(heading)
            along = cosine * (x_m - x) + sine * (y_m - y)
            right = cosine * (y_m - y) - sine * (x_m - x)
            curvature = self.curvature_per_m + self.rate_per_m2 * v
            step = along / max(1.0 - curvature * right, 0.1)
            v, before = min(max(v + step, self.low_m), self.high_m), v
            if abs(v - before) < 1e-12:
                break
        return v


class CentreLine:
    """The centre line of a road, for arrays and, with the suffix `_at`, for single points in plain floats."""

    def __init__(self, road: Road) -> None:
        self.length_m = road.length_m
        self.pieces = tuple(_pieces(road))
        # the middle of each piece, its reach from there, and its number
        self._discs = [
            (piece.x_m, piece.y_m, max(-piece.low_m, piece.high_m), index) for index, piece in enumerate(self.pieces)
        ]
        self._starts_m = np.array([piece.s_m + piece.low_m for piece in self.pieces[1:]])
        self._start_list_m = self._starts_m.tolist()

    def position(self, s_m: ArrayLike, lateral_m: ArrayLike = 0.0) -> Floats:
        """(..., 2) m, the world points at s along the line and `lateral` right of it."""
        s, lateral = np.broadcast_arrays(np.asarray(s_m, float), np.asarray(lateral_m, float))
        points = np.empty((*s.shape, 2))
        for piece, here in self._split(s):
            v, right = s[here] - piece.s_m, lateral[here]
            x, y = piece.point(v, np)
            heading = piece.heading(v)
            points[here] = np.stack([x - right * np.sin(heading), y + right * np.cos(heading)], axis=-1)
        return points

    def heading(self, s_m: ArrayLike) -> Floats:
        """(...) rad, the heading of the road; it is continuous, so it may leave [-pi, pi]."""
        s = np.asarray(s_m, float)
        heading = np.empty(s.shape)
        for piece, here in self._split(s):
            heading[here] = piece.heading(s[here] - piece.s_m)
        return heading

    def curvature(self, s_m: ArrayLike) -> Floats:
        """(...) 1/m, > 0 turns right; 0 beyond both ends."""
        s = np.asarray(s_m, float)
        curvature = np.empty(s.shape)
        for piece, here in self._split(s):
            curvature[here] = piece.curvature_per_m + piece.rate_per_m2 * (s[here] - piece.s_m)
        return curvature

    def local(self, points_m: ArrayLike) -> tuple[Floats, Floats]:
        """The inverse of `position`: (...) m along the line and (...) m right of it, for (..., 2) world points."""
        points = np.asarray(points_m, float)
        pairs = [self.local_at(x, y) for x, y in points.reshape(-1, 2).tolist()]
        local = np.array(pairs).reshape(*points.shape)
        return local[..., 0], local[..., 1]

    def position_at(self, s_m: float, lateral_m: float) -> tuple[float, float]:
        """`position` of one point."""
        piece = self._piece_at(s_m)
        v = s_m - piece.s_m
        x, y = piece.point(v)
        heading = piece.heading(v)
        return x - lateral_m * math.sin(heading), y + lateral_m * math.cos(heading)

    def heading_at(self, s_m: float) -> float:
        """`heading` at one s."""
        piece = self._piece_at(s_m)
        return float(piece.heading(s_m - piece.s_m))

    def curvature_at(self, s_m: float) -> float:
        """`curvature` at one s."""
        piece = self._piece_at(s_m)
        return piece.curvature_per_m + piece.rate_per_m2 * (s_m - piece.s_m)

    def local_at(self, x_m: float, y_m: float) -> tuple[float, float]:
        """`local` of one point; stateless, so the result does not depend on earlier queries."""
        hypot = math.hypot
        bounds = sorted([(hypot(x_m - x, y_m - y) - reach, index) for x, y, reach, index in self._discs])
        best_m, best = math.inf, (0.0, 0.0)
        for bound_m, index in bounds:
            if bound_m > best_m + TIE_M:
                break
            piece = self.pieces[index]
            v = piece.nearest(x_m, y_m)
            x, y = piece.point(v)
            distance_m = math.hypot(x_m - x, y_m - y)
            if distance_m < best_m + (TIE_M if piece.low_m < v < piece.high_m else -TIE_M):
                heading = piece.heading(v)
                lateral = math.cos(heading) * (y_m - y) - math.sin(heading) * (x_m - x)
                best_m, best = distance_m, (piece.s_m + v, lateral)
        return best

    def _piece_at(self, s_m: float) -> Piece:
        return self.pieces[bisect_right(self._start_list_m, s_m)]

    def _split(self, s: Floats) -> Iterator[tuple[Piece, Any]]:
        """Each piece with the mask of the s on it."""
        which = np.searchsorted(self._starts_m, s, side="right")
        for index in np.unique(which):
            yield self.pieces[index], which == index


def _pieces(road: Road) -> Iterator[Piece]:
    """All pieces in order; the first and the last are unbounded."""
    x, y = road.start_m
    heading, curvature, s = math.radians(road.heading_deg), 0.0, 0.0
    yield Piece(s, x, y, heading, 0.0, 0.0, -math.inf, 0.0)
    for segment in road.segments:
        start_curvature, rate, count = _bend(segment, curvature)
        length = segment.length_m / count
        for part in range(count):
            k = start_curvature + rate * length * part
            start = Piece(0.0, x, y, heading, k, rate, 0.0, length)
            half = length / 2.0
            yield Piece(s + half, *start.point(half), start.heading(half), k + rate * half, rate, -half, half)
            (x, y), heading = start.point(length), start.heading(length)
            s += length
        curvature = start_curvature + rate * segment.length_m
    yield Piece(s, x, y, heading, 0.0, 0.0, 0.0, math.inf)


def _bend(segment: Segment, curvature_before: float) -> tuple[float, float, int]:
    """The curvature at a segment's start, its rate, and the number of pieces for the quadrature."""
    if isinstance(segment, Line):
        return 0.0, 0.0, 1
    if isinstance(segment, Arc):
        return 1.0 / segment.radius_m, 0.0, 1
    end = 0.0 if segment.end_radius_m is None else 1.0 / segment.end_radius_m
    turn = max(abs(curvature_before), abs(end)) * segment.length_m
    return curvature_before, (end - curvature_before) / segment.length_m, max(1, math.ceil(turn / PIECE_TURN_RAD))
