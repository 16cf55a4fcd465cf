"""Cubic polynomials of the distance, and lists of them that follow each other."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from vpf_sim.scenarios.opendrive.xml_file import Element, number
from vpf_sim.types import Floats


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
