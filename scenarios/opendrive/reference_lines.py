"""The lines along which a route's s may run, as shifts from the reference lines of its roads."""

from collections.abc import Iterator

import numpy as np

from vpf_sim.scenarios.opendrive.carriageway import Carriageway, Stretch
from vpf_sim.scenarios.opendrive.geometry import Cubic
from vpf_sim.scenarios.opendrive.spans import span

INNER, CENTRE, OUTER = 0.0, 0.5, 1.0  # lines along the lanes, as shares of their width
Shifts = list[Cubic]  # of each stretch of a carriageway


def lines(lanes: Carriageway) -> Iterator[Shifts]:
    """The lines to try: along the lanes, then beside the reference lines, which have no kinks where lanes have.

    Along lanes of varying width, an edge may have no kinks where the centre has.
    """
    for share in (INNER, OUTER, CENTRE) if lanes.varies else (CENTRE,):
        yield [stretch.line(share) for stretch in lanes.stretches]
    yield beside_reference_lines(lanes, _middle_m(lanes))


def beside_reference_lines(lanes: Carriageway, aside_m: float) -> Shifts:
    """At a distance left of the first road's reference line, and beside those of the next ones as it goes on."""
    found: Shifts = []
    before: Stretch | None = None
    for stretch in lanes.stretches:
        if before is not None and before.leg != stretch.leg:
            aside_m = _going_on_m(before, found[-1], stretch)
        found.append(Cubic(stretch.low_m, aside_m))
        before = stretch
    return found


def _middle_m(lanes: Carriageway) -> float:
    """The median distance of the lanes' centre left of the first road's reference line."""
    own = [stretch for stretch in lanes.stretches if stretch.leg == lanes.stretches[0].leg]
    return float(np.median([stretch.line(CENTRE).at(np.array(stretch.low_m))[0] for stretch in own]))


def _going_on_m(before: Stretch, shift: Cubic, stretch: Stretch) -> float:
    """How far left of a road's reference line the line of the road before ends."""
    ahead, line = span(before, shift), span(stretch, Cubic(stretch.low_m, 0.0))
    end, start = ahead.at(np.array([ahead.last_m])).point[0], line.at(np.array([line.first_m]))
    right = ((end - start.point[0]) * np.exp(-1j * start.heading_rad[0])).imag  # y points right
    return float(-right if stretch.leg.forward else right)
