"""The widths of a route's lanes along its line, at as few places as it takes."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vpf_sim.scenarios.opendrive.carriageway import Carriageway, Stretch
from vpf_sim.scenarios.opendrive.chain import Chain
from vpf_sim.scenarios.opendrive.spans import Piece
from vpf_sim.types import Floats

CLOSE_M = 0.01  # largest error of a width between two places
APART_M = 0.5  # least distance of two places: a step of a width is spread over it
DIGITS = 4


def width_tables(lanes: Carriageway, curve: Sequence[tuple[Stretch, Piece]], line: Chain, share: float) -> Any:
    """The tables `[[road.widths]]` beside a line at a share of the lanes' width from their inner edge."""
    along = np.concatenate(line.along())
    widths = np.concatenate([stretch.widths_at(piece.s_m) for stretch, piece in curve])
    kept = _apart(along)
    along, widths = along[kept], widths[kept]
    left_share = share if lanes.has_left_inside else 1.0 - share
    return [
        {
            "s_m": round(float(s), DIGITS),
            "lanes_m": [round(float(one), DIGITS) for one in row],
            "left_edge_m": round(-left_share * float(row.sum()), DIGITS),
        }
        for s, row in ((along[i], widths[i]) for i in sorted(_needed(along, widths)))
    ]


def _apart(along_m: Floats) -> list[int]:
    """Places that are not too near to the one before, and the last."""
    kept = [0]
    for i, s in enumerate(along_m.tolist()):
        if s - along_m[kept[-1]] >= APART_M:
            kept.append(i)
    return kept


def _needed(along_m: Floats, widths_m: Floats) -> set[int]:
    """The places between which all widths are linear (Douglas and Peucker)."""
    needed, open_ = {0, len(along_m) - 1}, [(0, len(along_m) - 1)]
    while open_:
        first, last = open_.pop()
        if last - first < 2:
            continue
        share = ((along_m[first:last] - along_m[first]) / (along_m[last] - along_m[first]))[:, None]
        linear = widths_m[first] + share * (widths_m[last] - widths_m[first])
        error = np.abs(widths_m[first:last] - linear).max(axis=1)
        if error.max() > CLOSE_M:
            middle = first + int(error.argmax())
            needed.add(middle)
            open_ += [(first, middle), (middle, last)]
    return needed
