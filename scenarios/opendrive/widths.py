"""The borders of a route's lanes along its line, at as few places as it takes."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from vpf_sim.scenarios.opendrive.carriageway import Carriageway, Stretch
from vpf_sim.scenarios.opendrive.clothoid_line import Line
from vpf_sim.scenarios.opendrive.geometry import Cubic
from vpf_sim.scenarios.opendrive.spans import Element, Piece
from vpf_sim.types import Floats

CLOSE_M = 0.01  # largest error of a border between two places
APART_M = 0.5  # least distance of two places: a step of a width is spread over it
DIGITS = 4


class Places(NamedTuple):
    """Where the lanes' borders lie beside a line."""

    along_m: Floats  # (N,) from the start of the line
    borders_m: Floats  # (N, lanes + 1) right of it, from the left


def borders(stretch: Stretch, shift: Cubic, piece: Piece) -> Floats:
    """(N, lanes + 1) m, how far right of a line the borders are at the points of a piece, from the left.

    The line is `shift` left of the reference line.
    """
    widths = stretch.widths_at(piece.s_m)  # from the right
    sign = 1.0 if stretch.leg.forward else -1.0
    edge_is_left = not stretch.leg.road.is_left_hand  # the inner one
    inner = -sign * (stretch.line(0.0).at(piece.s_m)[0] - shift.at(piece.s_m)[0])
    left = inner if edge_is_left else inner - widths.sum(axis=1)
    return np.asarray(left[:, None] + np.cumsum(np.pad(widths[:, ::-1], ((0, 0), (1, 0))), axis=1))


def border_places(line: Line, borders_m: Sequence[Floats]) -> Places:
    """The borders along a line, by those beside each piece, at places that are not too near."""
    along = np.concatenate(line.along_m)
    kept = _apart(along)
    return Places(along[kept], np.concatenate(borders_m)[kept])


def is_plain(lanes: Carriageway, places: Places) -> bool:
    """Whether all lanes have the common width, on both sides of the line alike."""
    middle_m = 0.5 * (places.borders_m[:, 0] + places.borders_m[:, -1])
    return not lanes.varies and bool(np.abs(middle_m).max() <= CLOSE_M)


def width_tables(places: Places) -> Any:
    """The tables `[[road.widths]]`."""
    return [
        {
            "s_m": round(float(places.along_m[i]), DIGITS),
            "lanes_m": [round(float(one), DIGITS) for one in np.diff(places.borders_m[i])[::-1]],
            "left_edge_m": round(float(places.borders_m[i, 0]), DIGITS) + 0.0,
        }
        for i in sorted(_needed(*places))
    ]


def too_tight(elements: Iterable[Element], places: Places) -> str | None:
    """What is wrong with a bend that is narrower than the road on its inner side; None without one."""
    begin_m = 0.0
    for length_m, *curvatures in elements:
        ends = np.searchsorted(places.along_m, [begin_m, begin_m + length_m])
        near = places.borders_m[max(ends[0] - 1, 0) : ends[1] + 1]
        begin_m += length_m
        for sign, edge in ((1.0, -1), (-1.0, 0)):
            side_m, bend = float((sign * near[:, edge]).max()), max(sign * one for one in curvatures)
            if bend * side_m >= 1.0:
                return (
                    f"expected bends wider than the road inside them, {side_m:g} m, got a radius of {1.0 / bend:.2f} m"
                )
    return None


def _apart(along_m: Floats) -> list[int]:
    """Places that are not too near to the one before."""
    kept = [0]
    for i, s in enumerate(along_m.tolist()):
        if s - along_m[kept[-1]] >= APART_M:
            kept.append(i)
    return kept


def _needed(along_m: Floats, borders_m: Floats) -> set[int]:
    """The places between which all borders are linear (Douglas and Peucker)."""
    needed, open_ = {0, len(along_m) - 1}, [(0, len(along_m) - 1)]
    while open_:
        first, last = open_.pop()
        if last - first < 2:
            continue
        share = ((along_m[first:last] - along_m[first]) / (along_m[last] - along_m[first]))[:, None]
        linear = borders_m[first] + share * (borders_m[last] - borders_m[first])
        error = np.abs(borders_m[first:last] - linear).max(axis=1)
        if error.max() > CLOSE_M:
            middle = first + int(error.argmax())
            needed.add(middle)
            open_ += [(first, middle), (middle, last)]
    return needed
