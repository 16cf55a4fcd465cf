"""Pieces of curve as one chain of segments without kinks, near the true curve, over a map's small gaps.

A map's geometries continue only to some digits. Each piece is turned and scaled so that it ends where the true curve
does, so gaps do not add up. A turn that moves the end by less than `SLACK_M` is left out. Any other is spread over a
short beginning of the piece.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.scenarios.opendrive.clothoid_line import Line
from vpf_sim.scenarios.opendrive.spans import Element, Piece, points_along

SLACK_M = 0.002
MOST_KINK_RAD = 0.05
KINK_SHIFT_M = 0.002  # a corner is spread so far that it moves the line by this
WIDEST_KINK_M = 1000.0  # radius
LEAST_RATIO, MOST_RATIO = 0.01, 2.0  # of a piece's length after and before it is scaled
STRAIGHT_PER_M = 1e-10
SAME_PER_M = 1e-9
LEAD_M = 0.001  # arc from which a clothoid takes its first curvature


class Chain:
    """Clothoids from a start, grown by pieces of the true curve."""

    def __init__(self, first: Piece, half_width_m: float) -> None:
        self.start = complex(first.points[0])
        self.heading_rad = first.heading_rad
        self.elements: list[Element] = []
        self._half_width_m = half_width_m
        self._point, self._heading = self.start, self.heading_rad
        self._truth: list[tuple[Piece, float, float]] = []  # with the chain's length at its ends

    @property
    def length_m(self) -> float:
        return math.fsum(one.length_m for one in self.elements)

    def add(self, piece: Piece) -> None:
        """Go on to the end of a piece."""
        begin_m, goal = self.length_m, complex(piece.points[-1])
        elements = list(piece.elements)
        kink = self._aim(elements, goal)
        if abs(kink) * abs(goal - self._point) > SLACK_M:
            corner, elements[0] = self._corner(kink, elements[0])
            self._append([corner])
        chord = _chord(elements)
        direction = complex(np.exp(1j * (self._heading + np.angle(chord))))
        ratio = ((goal - self._point) * direction.conjugate()).real / abs(chord)
        if ratio > LEAST_RATIO:  # else a map's digits are larger than the piece
            self._append([one._replace(length_m=one.length_m * min(ratio, MOST_RATIO)) for one in elements])
        self._truth.append((piece, begin_m, self.length_m))

    def _aim(self, elements: Sequence[Element], goal: complex) -> float:
        """The turn, rad, after which elements lead to the goal; no more than a map's digits explain."""
        turn = wrap_angle(np.angle(goal - self._point) - np.angle(_chord(elements)) - self._heading)
        return min(max(turn, -MOST_KINK_RAD), MOST_KINK_RAD)

    def _corner(self, kink_rad: float, whole: Element) -> tuple[Element, Element]:
        """An element's beginning with a kink spread over it, and the rest of the element."""
        radius_m = max(min(2.0 * KINK_SHIFT_M / kink_rad**2, WIDEST_KINK_M), 2.0 * self._half_width_m)
        length_m = min(radius_m * abs(kink_rad), 0.5 * whole.length_m)
        bend = kink_rad / length_m
        cut = whole.first_per_m + (whole.last_per_m - whole.first_per_m) * length_m / whole.length_m
        corner = Element(length_m, whole.first_per_m + bend, cut + bend)
        return corner, Element(whole.length_m - length_m, cut, whole.last_per_m)

    def _append(self, elements: Sequence[Element]) -> None:
        self._point += complex(np.exp(1j * self._heading)) * _chord(elements)
        self._heading += sum(0.5 * (one.first_per_m + one.last_per_m) * one.length_m for one in elements)
        self.elements += elements

    def line(self) -> Line:
        """The line that it has become."""
        along = [
            begin_m + piece.distance_m * (end_m - begin_m) / piece.distance_m[-1]
            for piece, begin_m, end_m in self._truth
        ]
        return Line(self.start, self.heading_rad, tuple(self.elements), along)


def chained(pieces: Sequence[Piece], half_width_m: float) -> Line:
    """The chain of all pieces."""
    chain = Chain(pieces[0], half_width_m)
    for piece in pieces:
        chain.add(piece)
    return chain.line()


def _chord(elements: Sequence[Element]) -> complex:
    """From the start of a chain with heading 0 to its end."""
    length = np.array([sum(one.length_m for one in elements)])
    return complex(points_along(tuple(elements), 0j, 0.0, length)[0])


def merged(elements: Iterable[Element]) -> list[Element]:
    """Fewer elements: those that continue a line, an arc or a clothoid are one with it."""
    result: list[Element] = []
    for one in map(_cleaned, elements):
        if result and _continues(result[-1], one):
            before = result.pop()
            result.append(Element(before.length_m + one.length_m, before.first_per_m, one.last_per_m))
        else:
            result.append(one)
    return result


def _cleaned(one: Element) -> Element:
    """Without the rounding errors of lines and arcs."""
    first, last = (0.0 if abs(k) < STRAIGHT_PER_M else k for k in one[1:])
    return Element(one.length_m, first, first if abs(last - first) < STRAIGHT_PER_M else last)


def _continues(before: Element, after: Element) -> bool:
    rates = [(one.last_per_m - one.first_per_m) / one.length_m for one in (before, after)]
    step = abs(rates[1] - rates[0]) * (before.length_m + after.length_m)
    return abs(after.first_per_m - before.last_per_m) < SAME_PER_M and step < SAME_PER_M


def with_leads(elements: Iterable[Element]) -> list[Element]:
    """A clothoid of a scenario begins with the curvature of the segment before: a short arc where that differs.

    Arc and clothoid turn as much as the clothoid alone.
    """
    result: list[Element] = []
    curvature = 0.0
    for length_m, first, last in elements:
        if first != last and abs(first - curvature) > SAME_PER_M:
            lead_m = min(LEAD_M, 0.5 * length_m)
            first = (first * length_m + last * lead_m) / (length_m + lead_m)
            result.append(Element(lead_m, first, first))
            length_m -= lead_m
        result.append(Element(length_m, first, last))
        curvature = last
    return result
