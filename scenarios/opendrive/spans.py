"""The exact curve of the carriageway's centre: the reference line, shifted sideways by a polynomial.

At s, with the reference line's heading h, its speed v (1 unless a polynomial's length differs from its geometry's) and
the shift t to the left, the centre moves by a = v - t h' along the heading and by t' to the left, so that

    heading = h + atan2(t', a),    turn = h' + (t'' a - t' a') / (a^2 + t'^2).

Derivatives are by s. Curvature is the turn divided by the centre's own speed, the root of a^2 + t'^2.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive.carriageway import Stretch
from vpf_sim.scenarios.opendrive.geometry import NODES, WEIGHTS, Complexes, Cubic, Geometry, displacement
from vpf_sim.types import Floats

CLOSE_M = 0.001  # largest distance of a piece from the curve
MOST_TURN_RAD = 1.0
SAMPLE_M = 1.0
MOST_SAMPLES = 200
LEAST_M = 0.01  # of s: a curve that is no clothoid even there is not smooth
SAME_TURN_RAD = 1e-9


class Centre(NamedTuple):
    """The carriageway's centre at some s, in our axes (y right) and along the drive."""

    point: Complexes  # m, x + iy
    heading_rad: Floats
    turn_per_m: Floats  # by s
    speed: Floats  # metres of the curve for a metre of s


@dataclass(frozen=True, slots=True)
class Span:
    """A smooth part of the centre's curve, driven from `first_m` to `last_m` of the road's s."""

    where: str  # the road in messages
    geometry: Geometry
    shift: Cubic
    first_m: float
    last_m: float

    def at(self, s_m: Floats) -> Centre:
        """Raises InputError where the road bends more than the shift allows."""
        line, (t, slope, bend) = self.geometry.at(s_m), self.shift.at(s_m)
        along = self.geometry.stretch - t * line.turn_per_m
        if along.min() <= 0.0:
            raise InputError(
                f"{self.where}: planView: expected bends wider than the lanes' distance from the reference line, "
                f"got a radius of {1.0 / np.abs(line.turn_per_m).max():.2f} m"
            )
        along_slope = -(slope * line.turn_per_m + t * line.turn_rate_per_m2)
        heading = line.heading_rad + np.arctan2(slope, along)
        turn = line.turn_per_m + (bend * along - slope * along_slope) / (along**2 + slope**2)
        point = line.point + 1j * np.exp(1j * line.heading_rad) * t
        forward = self.last_m > self.first_m
        # Our y has the other sign, and so have headings and turns; a drive against s changes the turn again.
        return Centre(
            np.conj(point),
            -heading if forward else np.pi - heading,
            -turn if forward else turn,
            np.hypot(along, slope),
        )


def span(stretch: Stretch, shift: Cubic) -> Span:
    """The curve of a stretch, `shift` left of the reference line."""
    geometries = stretch.leg.road.geometries
    middle_m = 0.5 * (stretch.low_m + stretch.high_m)
    geometry = next((one for one in reversed(geometries) if one.s_m <= middle_m), geometries[0])
    ends = (stretch.low_m, stretch.high_m)
    first_m, last_m = ends if stretch.leg.forward else reversed(ends)
    return Span(stretch.leg.road.where, geometry, shift, first_m, last_m)


class Element(NamedTuple):
    """A clothoid; lines and arcs have the same curvature at both ends. Curvature > 0 turns right."""

    length_m: float
    first_per_m: float
    last_per_m: float


@dataclass(frozen=True, slots=True)
class Piece:
    """One or two clothoids, and the true curve beside them."""

    where: str
    elements: tuple[Element, ...]
    heading_rad: float  # of the true curve at its start
    distance_m: Floats  # (N,) along the curve
    points: Complexes  # (N,) there
    s_m: Floats  # (N,) of the road there

    @property
    def is_close(self) -> bool:
        """Whether the clothoids turn little and are within a millimetre of the curve."""
        bend = sum(max(abs(one.first_per_m), abs(one.last_per_m)) * one.length_m for one in self.elements)
        if not bend <= MOST_TURN_RAD:  # nor not a number
            return False
        start = self.points[0], self.heading_rad
        apart = np.abs(points_along(self.elements, *start, self.distance_m) - self.points)
        return bool(apart.max() <= CLOSE_M)


def pieces(span: Span) -> Iterator[Piece]:
    """A span in as many pieces as it takes; each is within a millimetre of the curve."""
    one = _fit(span)
    if one.is_close:
        yield one
        return
    if abs(span.last_m - span.first_m) < LEAST_M:
        raise InputError(f"{span.where}: planView: expected a smooth curve, got a corner at s = {span.first_m:.2f} m")
    middle_m = 0.5 * (span.first_m + span.last_m)
    yield from pieces(Span(span.where, span.geometry, span.shift, span.first_m, middle_m))
    yield from pieces(Span(span.where, span.geometry, span.shift, middle_m, span.last_m))


def _fit(span: Span) -> Piece:
    """Two clothoids of half the span's length, or one if it has the same turn."""
    count = min(max(4, math.ceil(abs(span.last_m - span.first_m) / SAMPLE_M)), MOST_SAMPLES)
    s = np.linspace(span.first_m, span.last_m, count + 1)
    step = abs(s[1] - s[0])
    inside = span.at(s[:-1, None] + (s[1] - s[0]) * NODES)
    distance = np.concatenate([[0.0], np.cumsum(step * (inside.speed @ WEIGHTS))])
    length, turn = float(distance[-1]), float(np.sum(step * (inside.turn_per_m @ WEIGHTS)))
    ends = span.at(s)
    first, last = (float(ends.turn_per_m[i] / ends.speed[i]) for i in (0, -1))
    middle = 2.0 * turn / length - 0.5 * (first + last)
    elements: tuple[Element, ...] = (Element(length / 2.0, first, middle), Element(length / 2.0, middle, last))
    if abs(middle - 0.5 * (first + last)) * length <= SAME_TURN_RAD:
        elements = (Element(length, first, last),)
    return Piece(span.where, elements, float(ends.heading_rad[0]), distance, ends.point, s)


def points_along(elements: tuple[Element, ...], start: complex, heading_rad: float, distance_m: Floats) -> Complexes:
    """(N,) points at distances along a chain of clothoids."""
    length, first, last = np.array(elements).T
    rate = (last - first) / length
    begins = np.concatenate([[0.0], np.cumsum(length)])
    headings = heading_rad + np.concatenate([[0.0], np.cumsum(0.5 * (first + last) * length)])
    chords = np.exp(1j * headings[:-1]) * displacement(first, rate, length)
    corners = start + np.concatenate([[0.0], np.cumsum(chords)])
    which = np.clip(np.searchsorted(begins, distance_m, side="right") - 1, 0, len(length) - 1)
    rest = displacement(first[which], rate[which], distance_m - begins[which])
    return np.asarray(corners[which] + np.exp(1j * headings[which]) * rest)
