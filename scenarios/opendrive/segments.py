"""The segments of a scenario's road from a chain of clothoids, in few digits."""

import math
from collections.abc import Iterable, Iterator
from typing import Any

from vpf_sim.scenarios.opendrive.chain import SAME_PER_M
from vpf_sim.scenarios.opendrive.pieces import Element

LENGTH_DIGITS = 6  # micrometres
RADIUS_DIGITS = 9  # of all digits

Segment = dict[str, Any]


def segments(elements: Iterable[Element]) -> list[Segment]:
    """As tables of a scenario file."""
    return [one for element in elements if (one := _segment(element))["length_m"] > 0.0]


def _segment(element: Element) -> Segment:
    length_m, first, last = element
    length = {"length_m": round(float(length_m), LENGTH_DIGITS)}
    if first != last:
        end = {"end_radius_m": _radius(last)} if last != 0.0 else {}
        return {"kind": "clothoid", **length, **end}
    return {"kind": "arc", **length, "radius_m": _radius(first)} if first != 0.0 else {"kind": "line", **length}


def _radius(curvature: float) -> float:
    return float(f"{1.0 / curvature:.{RADIUS_DIGITS}g}")


def elements(tables: Iterable[Segment]) -> Iterator[Element]:
    """The clothoids that a road is made of from the tables."""
    curvature = 0.0
    for one in tables:
        first = curvature
        if one["kind"] == "line":
            first = curvature = 0.0
        elif one["kind"] == "arc":
            first = curvature = 1.0 / one["radius_m"]
        else:
            curvature = 1.0 / one.get("end_radius_m", math.inf)
        yield Element(one["length_m"], first, curvature)


def tightest_m(elements: Iterable[Element], sign: float) -> float:
    """The least radius of a chain's bends to the right (1) or left (-1); a large one where there is none."""
    return 1.0 / max([SAME_PER_M, *(sign * k for one in elements for k in one[1:])])
