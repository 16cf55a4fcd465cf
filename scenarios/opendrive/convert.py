"""The table `[road]` of a scenario from a map's road."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from vpf_sim.configuration import build
from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive import chain, segments
from vpf_sim.scenarios.opendrive.carriageway import Carriageway, carriageway
from vpf_sim.scenarios.opendrive.keys import OpenDriveFile
from vpf_sim.scenarios.opendrive.marks import look
from vpf_sim.scenarios.opendrive.network import Network
from vpf_sim.scenarios.opendrive.pieces import pieces
from vpf_sim.scenarios.opendrive.routes import find_route
from vpf_sim.scenarios.opendrive.spans import span
from vpf_sim.scenarios.parts import FARTHEST_M

HEADING_DIGITS = 9


def road_table(table: dict[str, Any], file: str) -> dict[str, Any]:
    """The keys of `Road` for a table that names a map; `file` is the scenario's. Raises InputError."""
    wanted = build(OpenDriveFile, {"road": table}, file).road
    network = Network(Path(file).parent / wanted.opendrive, f"{file}: road.opendrive")
    with np.errstate(all="ignore"):  # numbers of no road are found where they are used
        return _table(carriageway(find_route(network, wanted, file)), table.get("look", {}))


def _table(lanes: Carriageway, own_look: dict[str, Any]) -> dict[str, Any]:
    return {
        "lanes": lanes.lanes,
        "lane_width_m": lanes.lane_width_m,
        "oncoming_lanes": 0,
        **_centre_line(lanes),
        "look": {**look(lanes), **own_look},
    }


def _centre_line(lanes: Carriageway) -> dict[str, Any]:
    """Start, heading and segments."""
    curve = [piece for stretch in lanes.stretches for piece in pieces(span(stretch))]
    line = chain.Chain(curve[0], lanes.half_width_m)
    for piece in curve:
        line.add(piece)
    found = segments.segments(chain.with_leads(chain.merged(line.elements)))
    made = [*segments.elements(found)]
    line.check(made)
    if (radius_m := segments.tightest_m(made)) <= lanes.half_width_m:
        raise InputError(
            f"{curve[0].where}: planView: expected bends wider than half the carriageway, {lanes.half_width_m:g} m, "
            f"got a radius of {radius_m:.2f} m"
        )
    start = line.start
    is_near = max(abs(start.real), abs(start.imag)) <= FARTHEST_M
    return {
        # A map whose origin is far away, as with UTM coordinates, begins at our origin.
        "start_m": [round(start.real, 6), round(start.imag, 6)] if is_near else [0.0, 0.0],
        "heading_deg": round(math.degrees(math.remainder(line.heading_rad, math.tau)), HEADING_DIGITS),
        "segments": found,
    }
