"""The carriageway of a route: its lanes, their width, where its centre lies, and the look of its marks."""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive.geometry import Cubic, valid_at
from vpf_sim.scenarios.opendrive.lanes import LaneSection, Mark
from vpf_sim.scenarios.opendrive.network import MapRoad
from vpf_sim.scenarios.opendrive.routes import Leg, Route, Track
from vpf_sim.types import Floats

TAPER_M = 1.0  # a lane that is narrower somewhere does not run through
WIDTH_TOLERANCE_M = 0.05
SAMPLE_M = 1.0
SHORT_M = 0.01  # a part of a road that is shorter is merged with its neighbour
RIGHT, LEFT, INSIDE = "right", "left", "inside"


@dataclass(frozen=True, slots=True)
class Stretch:
    """The part of a section where geometry, polynomials and marks stay the same."""

    leg: Leg
    section: LaneSection
    low_m: float  # s
    high_m: float
    lanes: tuple[int, ...]  # of the carriageway, from the right

    def widths_m(self, lane: int) -> Floats:
        """(N,) m, the width of a lane along the stretch, about every metre."""
        count = 2 + int((self.high_m - self.low_m) / SAMPLE_M)
        s = np.linspace(self.low_m, self.high_m, count)
        return np.asarray(self._width(lane).at(s)[0])

    def line(self, share: float) -> Cubic:
        """How far a line is left of the reference line: from 0, the lanes' inner edge, by 0.5, their centre, to 1."""
        offset = Cubic(self.low_m, 0.0).plus(valid_at(self.leg.road.lane_offsets, self._inside_m), 1.0)
        sign = 1.0 if self.leg.is_left else -1.0
        inner = min(map(abs, self.lanes))
        for lane in self.section.lanes:
            if lane != 0 and (lane > 0) == self.leg.is_left and (abs(lane) < inner or lane in self.lanes):
                offset = offset.plus(self._width(lane), sign * (share if lane in self.lanes else 1.0))
        return offset

    def widths_at(self, s_m: Floats) -> Floats:
        """(N, lanes) m, the widths of the lanes from the right at each s."""
        return np.stack([self._width(lane).at(s_m)[0] for lane in self.lanes], axis=1)

    def _width(self, lane: int) -> Cubic:
        return valid_at(self.section.lanes[lane].widths, self._inside_m)

    @property
    def _inside_m(self) -> float:
        return 0.5 * (self.low_m + self.high_m)


@dataclass(frozen=True, slots=True)
class Carriageway:
    """The adjacent lanes that run through a route."""

    stretches: tuple[Stretch, ...]
    lanes: int
    lane_width_m: float  # the median
    varies: bool  # whether a lane has another width somewhere

    @property
    def has_left_inside(self) -> bool:
        """Whether the lanes' left edge is the one towards the reference line."""
        return not self.stretches[0].leg.road.is_left_hand


def carriageway(route: Route) -> Carriageway:
    """The lanes of a route, counted from the right. Raises InputError if no lane runs through."""
    wide = [track for track in route.tracks if _least_width(route, track) >= TAPER_M]
    if not wide:
        road = route.legs[-1].road
        raise InputError(f"{road.where}: lanes: expected a driving lane of {TAPER_M:g} m or more all along, got none")
    tracks = wide[:1]
    for track in wide[1:]:
        if any(abs(here - there) != 1 for here, there in zip(tracks[-1], track, strict=True)):
            break
        tracks.append(track)
    stretches = [*_stretches(route.legs, list(zip(*tracks, strict=True)))]
    widths = np.concatenate([stretch.widths_m(lane) for stretch in stretches for lane in stretch.lanes])
    common = float(np.median(widths))
    varies = bool(np.abs(widths - common).max() > WIDTH_TOLERANCE_M)
    return Carriageway(tuple(stretches), len(tracks), round(common, 4), varies)


def _least_width(route: Route, track: Track) -> float:
    stretches = _stretches(route.legs, [(lane,) for lane in track])
    return min(float(stretch.widths_m(*stretch.lanes).min()) for stretch in stretches)


def _stretches(legs: Sequence[Leg], lanes: Sequence[tuple[int, ...]]) -> Iterator[Stretch]:
    """Roads cut where a geometry, a polynomial or a mark begins, in the order of the drive; lanes by section."""
    of_section = iter(lanes)
    for leg in legs:
        for section, low_m, high_m, ids in _merged([(one, next(of_section)) for one in leg.sections], leg.forward):
            cuts = [low_m, *_cuts(leg.road, section, max(map(abs, ids)), low_m, high_m), high_m]
            parts = [Stretch(leg, section, low, high, ids) for low, high in pairwise(cuts)]
            yield from parts if leg.forward else reversed(parts)


def _merged(
    sections: Sequence[tuple[LaneSection, tuple[int, ...]]], forward: bool
) -> list[tuple[LaneSection, float, float, tuple[int, ...]]]:
    """Sections with their ends, m, in the order given; one that is too short to notice is part of its neighbour."""
    along = sections if forward else sections[::-1]
    low_m, end_m = along[0][0].s_m, along[-1][0].end_m
    kept: list[tuple[LaneSection, float, float, tuple[int, ...]]] = []
    for section, ids in along:
        if section.end_m - low_m >= SHORT_M:
            kept.append((section, low_m, section.end_m, ids))
            low_m = section.end_m
    if not kept:
        section, ids = max(along, key=lambda one: one[0].end_m - one[0].s_m)
        kept = [(section, along[0][0].s_m, end_m, ids)]
    section, low_m, _, ids = kept[-1]
    kept[-1] = section, low_m, end_m, ids
    return kept if forward else kept[::-1]


def _cuts(road: MapRoad, section: LaneSection, outermost: int, low_m: float, high_m: float) -> list[float]:
    """s between a section's ends where a geometry, a polynomial or a mark begins."""
    lanes = [lane for lane in section.lanes.values() if abs(lane.id) <= outermost]
    starts = {one.s_m for one in road.lane_offsets}
    starts |= {width.s_m for lane in lanes for width in lane.widths}
    starts |= {mark.s_m for lane in lanes for mark in lane.marks}
    kept: list[float] = []
    for s in sorted(starts):
        if s - (kept[-1] if kept else low_m) >= SHORT_M and high_m - s >= SHORT_M:
            kept.append(s)
    geometries = {one.s_m for one in road.geometries if low_m + 1e-6 < one.s_m < high_m - 1e-6}
    return sorted(geometries.union(kept))


def look(carriageway: Carriageway) -> dict[str, str]:
    """What the marks say of `[road.look]`; nothing where a map has none."""
    solid: dict[str, float] = defaultdict(float)  # m, by border
    painted: dict[str, float] = defaultdict(float)  # m, by colour
    has_marks = False
    for stretch in carriageway.stretches:
        length_m = stretch.high_m - stretch.low_m
        for place, marks in _borders(stretch):
            has_marks = has_marks or bool(marks)
            mark = _valid(marks, 0.5 * (stretch.low_m + stretch.high_m))
            solid[place] += length_m * ("solid" in mark.kind)
            painted[mark.color] += length_m * ("solid" in mark.kind or "broken" in mark.kind)
    if not has_marks:
        return {}
    all_m = sum(stretch.high_m - stretch.low_m for stretch in carriageway.stretches)
    edges = [place for place in (LEFT, RIGHT) if 2.0 * solid[place] > all_m]
    is_yellow = 2.0 * painted["yellow"] > sum(painted.values())
    return {
        "edge_lines": "both" if len(edges) == 2 else edges[0] if edges else "none",
        "lines": "yellow" if is_yellow else "white",
    }


def _borders(stretch: Stretch) -> list[tuple[str, Sequence[Mark]]]:
    """The places and marks of the lanes' borders, from the outermost to the reference line's side."""
    section, lanes = stretch.section, stretch.lanes
    places = [RIGHT, *[INSIDE] * (len(lanes) - 1), LEFT]
    if stretch.leg.road.is_left_hand:
        lanes, places = lanes[::-1], places[::-1]
    return list(
        zip(places, [*(section.lanes[one].marks for one in lanes), _inner_marks(section, lanes[-1])], strict=True)
    )


def _inner_marks(section: LaneSection, lane: int) -> Sequence[Mark]:
    """The marks on a lane's border towards the reference line: those of its neighbour there."""
    neighbour = section.lanes.get(lane - 1 if lane > 0 else lane + 1)
    return () if neighbour is None else neighbour.marks


def _valid(marks: Sequence[Mark], s_m: float) -> Mark:
    count = bisect_right([one.s_m for one in marks], s_m)
    return marks[count - 1] if count else Mark(0.0, "none", "")
