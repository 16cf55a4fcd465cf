"""Lanes of a road's section: type, width, links and marks. Ids count from the reference line, + to the left."""

from collections.abc import Sequence
from dataclasses import dataclass

from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive.cubics import Cubic, read_cubics
from vpf_sim.scenarios.opendrive.xml_file import Element, integer, number

DRIVABLE = {"driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp"}


@dataclass(frozen=True, slots=True)
class Mark:
    """Paint on a lane's border from `s_m` on."""

    s_m: float
    kind: str
    color: str


@dataclass(frozen=True, slots=True)
class Lane:
    """A lane of one section; `marks` are on its border away from the reference line."""

    id: int
    kind: str
    widths: Sequence[Cubic]
    predecessors: Sequence[int]
    successors: Sequence[int]
    marks: Sequence[Mark]

    @property
    def is_drivable(self) -> bool:
        return self.kind in DRIVABLE


@dataclass(frozen=True, slots=True)
class LaneSection:
    """The lanes of a road from `s_m` to `end_m`, by id."""

    s_m: float
    end_m: float
    lanes: dict[int, Lane]

    def drivable(self, left: bool) -> list[int]:
        """The drivable lanes on one side of the reference line, from it outwards."""
        ids = sorted(self.lanes, key=abs)
        return [one for one in ids if one != 0 and (one > 0) == left and self.lanes[one].is_drivable]


def read_section(element: Element, s_m: float, end_m: float, where: str) -> LaneSection:
    """A `<laneSection>` that ends at `end_m`."""
    elements = [one for side in ("left", "center", "right") for one in element.findall(f"{side}/lane")]
    lanes = [_read_lane(one, s_m, f"{where}.lane") for one in elements]
    return LaneSection(s_m, end_m, {lane.id: lane for lane in lanes})


def _read_lane(element: Element, start_m: float, where: str) -> Lane:
    lane = integer(element, "id", where)
    where = f"{where} {lane}"
    if element.find("border") is not None and element.find("width") is None:
        raise InputError(f"{where}: expected widths, got borders")
    marks = [
        Mark(start_m + number(one, "sOffset", f"{where}.roadMark", 0.0), one.get("type", "none"), one.get("color", ""))
        for one in element.findall("roadMark")
    ]
    return Lane(
        lane,
        element.get("type", "none"),
        read_cubics(element.findall("width"), "sOffset", f"{where}.width", start_m),
        [integer(one, "id", f"{where}.link") for one in element.findall("link/predecessor")],
        [integer(one, "id", f"{where}.link") for one in element.findall("link/successor")],
        marks,
    )
