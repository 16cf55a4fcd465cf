"""The look of a road from its marks: which edge lines are painted, and the colour of the paint."""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Sequence

from vpf_sim.scenarios.opendrive.carriageway import Carriageway, Stretch
from vpf_sim.scenarios.opendrive.lanes import LaneSection, Mark

RIGHT, LEFT, INSIDE = "right", "left", "inside"


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
