"""The table `[road]` of a scenario from a map's road, along the first line on which s can run."""

import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from vpf_sim.configuration import TomlTable, build
from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive import chain
from vpf_sim.scenarios.opendrive.carriageway import Carriageway, Stretch, carriageway, look
from vpf_sim.scenarios.opendrive.geometry import Cubic
from vpf_sim.scenarios.opendrive.network import Network
from vpf_sim.scenarios.opendrive.road_section import OpenDriveFile, OpenDriveRoad
from vpf_sim.scenarios.opendrive.routes import find_route
from vpf_sim.scenarios.opendrive.smoothing import smoothed
from vpf_sim.scenarios.opendrive.spans import Element, pieces, span
from vpf_sim.scenarios.opendrive.widths import border_places, borders, is_plain, too_tight, width_tables
from vpf_sim.scenarios.parts import FARTHEST_M

HEADING_DIGITS = 9
WAVES_M = (1.0, 2.0, 4.0)  # that are smoothed out, in order
LENGTH_DIGITS = 6  # micrometres
RADIUS_DIGITS = 9  # of all digits
INNER, CENTRE, OUTER = 0.0, 0.5, 1.0  # lines along the lanes, as shares of their width

Segment = TomlTable
Shifts = list[Cubic]  # of each stretch of a carriageway, from its reference line


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


def road_table(table: TomlTable, file: str) -> TomlTable:
    """The keys of `Road` for a table that names a map; `file` is the scenario's. Raises InputError."""
    wanted = build(OpenDriveFile, {"road": table}, file).road
    network = Network(Path(file).parent / wanted.opendrive, f"{file}: road.opendrive")
    return route_table(network, wanted, file, table.get("look", {}))


def route_table(network: Network, wanted: OpenDriveRoad, file: str, own_look: TomlTable) -> TomlTable:
    """The same for a map that is read."""
    with np.errstate(all="ignore"):  # numbers of no road are found where they are used
        return _table(carriageway(find_route(network, wanted, file)), own_look)


def _table(lanes: Carriageway, own_look: TomlTable) -> TomlTable:
    return {
        "lanes": lanes.lanes,
        "lane_width_m": lanes.lane_width_m,
        "oncoming_lanes": 0,
        **_first_that_fits(lanes),
        "look": {**look(lanes), **own_look},
    }


def _first_that_fits(lanes: Carriageway) -> TomlTable:
    """Start, heading, segments and widths, for the first line that fits.

    Where no line of the map is smooth enough, a reference line is smoothed.
    """
    fault = None
    for shifts in lines(lanes):
        try:
            return _along(lanes, shifts)
        except InputError as error:
            fault = error
    assert fault is not None
    for wave_m in WAVES_M:
        with suppress(InputError):
            return _along(lanes, beside_reference_lines(lanes, 0.0), wave_m)
    raise fault


def _along(lanes: Carriageway, shifts: Shifts, wave_m: float | None = None) -> TomlTable:
    """Start, heading, segments and widths, for one line, without waves shorter than about `wave_m`."""
    curve = [
        (stretch, shift, piece)
        for stretch, shift in zip(lanes.stretches, shifts, strict=True)
        for piece in pieces(span(stretch, shift))
    ]
    borders_m = [borders(*one) for one in curve]
    truth = [piece for _, _, piece in curve]
    widest_m = max(float(np.ptp(one, axis=1).max()) for one in borders_m)
    line = chain.chained(truth, 0.5 * widest_m) if wave_m is None else smoothed(truth, wave_m)
    found = segments(chain.with_leads(chain.merged(line.elements)))
    made = (*elements(found),)
    line._replace(elements=made).check(truth)
    places = border_places(line, borders_m)
    if fault := too_tight(made, places):
        raise InputError(f"{curve[0][2].where}: planView: {fault}")
    widths = {} if is_plain(lanes, places) else {"widths": width_tables(places)}
    start = line.start
    is_near = max(abs(start.real), abs(start.imag)) <= FARTHEST_M
    return {
        # A map whose origin is far away, as with UTM coordinates, begins at our origin.
        "start_m": [round(start.real, 6), round(start.imag, 6)] if is_near else [0.0, 0.0],
        "heading_deg": round(math.degrees(math.remainder(line.heading_rad, math.tau)), HEADING_DIGITS),
        "segments": found,
        **widths,
    }


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
