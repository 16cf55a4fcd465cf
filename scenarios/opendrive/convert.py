"""The table `[road]` of a scenario from a map's road."""

import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vpf_sim.configuration import build
from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive import chain
from vpf_sim.scenarios.opendrive.carriageway import Carriageway, carriageway, look
from vpf_sim.scenarios.opendrive.chain import SAME_PER_M
from vpf_sim.scenarios.opendrive.keys import OpenDriveFile, OpenDriveRoad
from vpf_sim.scenarios.opendrive.network import Network
from vpf_sim.scenarios.opendrive.routes import find_route
from vpf_sim.scenarios.opendrive.spans import Element, pieces, span
from vpf_sim.scenarios.opendrive.widths import width_tables
from vpf_sim.scenarios.parts import FARTHEST_M

HEADING_DIGITS = 9
INNER, CENTRE, OUTER = 0.0, 0.5, 1.0  # lines along the lanes, as shares of their width
MEANING = {INNER: "the carriageway", CENTRE: "half the carriageway", OUTER: "the carriageway"}
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


def road_table(table: dict[str, Any], file: str) -> dict[str, Any]:
    """The keys of `Road` for a table that names a map; `file` is the scenario's. Raises InputError."""
    wanted = build(OpenDriveFile, {"road": table}, file).road
    network = Network(Path(file).parent / wanted.opendrive, f"{file}: road.opendrive")
    return route_table(network, wanted, file, table.get("look", {}))


def route_table(network: Network, wanted: OpenDriveRoad, file: str, own_look: dict[str, Any]) -> dict[str, Any]:
    """The same for a map that is read."""
    with np.errstate(all="ignore"):  # numbers of no road are found where they are used
        return _table(carriageway(find_route(network, wanted, file)), own_look)


def _table(lanes: Carriageway, own_look: dict[str, Any]) -> dict[str, Any]:
    return {
        "lanes": lanes.lanes,
        "lane_width_m": lanes.lane_width_m,
        "oncoming_lanes": 0,
        **_first_that_fits(lanes),
        "look": {**look(lanes), **own_look},
    }


def _first_that_fits(lanes: Carriageway) -> dict[str, Any]:
    """The line along which s runs: the centre of the lanes, or where their width changes an edge without kinks."""
    faults = []
    for share in (INNER, OUTER, CENTRE) if lanes.varies else (CENTRE,):
        try:
            return _line(lanes, share)
        except InputError as error:
            faults.append(error)
    raise faults[0]


def _line(lanes: Carriageway, share: float) -> dict[str, Any]:
    """Start, heading, segments and widths, for a line at a share of the lanes' width from their inner edge."""
    curve = [(stretch, piece) for stretch in lanes.stretches for piece in pieces(span(stretch, share))]
    width_m = max(float(stretch.widths_at(piece.s_m).sum(axis=1).max()) for stretch, piece in curve)
    if not lanes.varies:
        width_m = lanes.lanes * lanes.lane_width_m
    line = chain.Chain(curve[0][1], 0.5 * width_m)
    for _, piece in curve:
        line.add(piece)
    found = segments(chain.with_leads(chain.merged(line.elements)))
    made = [*elements(found)]
    line.check(made)
    left_share = share if lanes.has_left_inside else 1.0 - share
    for sign, side in ((1.0, 1.0 - left_share), (-1.0, left_share)):
        if (radius_m := tightest_m(made, sign)) <= side * width_m:
            raise InputError(
                f"{curve[0][1].where}: planView: expected bends wider than {MEANING[share]}, {side * width_m:g} m, "
                f"got a radius of {radius_m:.2f} m"
            )
    widths = {"widths": width_tables(lanes, curve, line, share)} if lanes.varies else {}
    start = line.start
    is_near = max(abs(start.real), abs(start.imag)) <= FARTHEST_M
    return {
        # A map whose origin is far away, as with UTM coordinates, begins at our origin.
        "start_m": [round(start.real, 6), round(start.imag, 6)] if is_near else [0.0, 0.0],
        "heading_deg": round(math.degrees(math.remainder(line.heading_rad, math.tau)), HEADING_DIGITS),
        "segments": found,
        **widths,
    }
