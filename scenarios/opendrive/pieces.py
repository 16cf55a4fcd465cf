"""A smooth curve as clothoids: its own curvature at their ends, and its own turn in between."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive.cubics import NODES, WEIGHTS, Complexes, displacement
from vpf_sim.scenarios.opendrive.spans import Span
from vpf_sim.types import Floats

CLOSE_M = 0.001  # largest distance of a piece from the curve
MOST_TURN_RAD = 1.0
SAMPLE_M = 1.0
MOST_SAMPLES = 200
LEAST_M = 0.01  # of s: a curve that is no clothoid even there is not smooth
SAME_TURN_RAD = 1e-9


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
    ways = np.exp(1j * headings[:-1]) * displacement(first, rate, length)
    corners = start + np.concatenate([[0.0], np.cumsum(ways)])
    which = np.clip(np.searchsorted(begins, distance_m, side="right") - 1, 0, len(length) - 1)
    way = displacement(first[which], rate[which], distance_m - begins[which])
    return np.asarray(corners[which] + np.exp(1j * headings[which]) * way)
