"""Lanes of a road's section: type, width, links and marks. Ids count from the reference line, + to the left."""

from dataclasses import dataclass
from functools import cached_property

from vpf_sim.errors import InputError
from vpf_sim.scenarios.opendrive.geometry import Cubic, read_cubics
from vpf_sim.scenarios.opendrive.xml_file import Element, integer, number

DRIVABLE = {"driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp"}


@dataclass(frozen=True, slots=True)
class Mark:
    """Paint on a lane's border from `s_m` on."""

    s_m: float
    kind: str
    color: str


class Lane:
    """A lane of one section, whose parts are read when they are needed."""

    def __init__(self, element: Element, start_m: float, where: str) -> None:
        self.id = integer(element, "id", where)
        self.kind = element.get("type", "none")
        self._element, self._start_m, self._where = element, start_m, f"{where} {self.id}"

    @property
    def is_drivable(self) -> bool:
        return self.kind in DRIVABLE

    @cached_property
    def widths(self) -> list[Cubic]:
        elements = self._element.findall("width")
        if not elements and self._element.find("border") is not None:
            raise InputError(f"{self._where}: expected widths, got borders")
        return read_cubics(elements, "sOffset", f"{self._where}.width", self._start_m)

    @cached_property
    def marks(self) -> list[Mark]:
        """Paint on the border away from the reference line."""
        where = f"{self._where}.roadMark"
        return [
            Mark(self._start_m + number(one, "sOffset", where, 0.0), one.get("type", "none"), one.get("color", ""))
            for one in self._element.findall("roadMark")
        ]

    def linked(self, to_successor: bool) -> list[int]:
        """The lanes of the next section or road, or of the one before, that its links name."""
        links = self._element.findall(f"link/{'successor' if to_successor else 'predecessor'}")
        return [integer(one, "id", f"{self._where}.link") for one in links if one.get("id")]


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


def is_for_side(element: Element, left: bool) -> bool:
    """Whether a `<laneSection>` is valid for a side: one with `singleSide` has lanes on one only."""
    is_single = element.get("singleSide", "").strip().lower() in ("true", "1")
    return not is_single or element.find(f"{'left' if left else 'right'}/lane") is not None


def read_section(element: Element, s_m: float, end_m: float, left: bool, where: str) -> LaneSection:
    """One side of a `<laneSection>` that ends at `end_m`, and its middle."""
    elements = [one for side in ("center", "left" if left else "right") for one in element.findall(f"{side}/lane")]
    lanes = [Lane(one, s_m, f"{where}.lane") for one in elements]
    return LaneSection(s_m, end_m, {lane.id: lane for lane in lanes})
