"""The roads and junctions of an OpenDRIVE map; a road is read when it is needed."""

from collections import defaultdict
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from vpf_sim.errors import InputError, shown
from vpf_sim.scenarios.opendrive import xml_file
from vpf_sim.scenarios.opendrive.geometry import Cubic, Geometry, read_cubics, read_geometry
from vpf_sim.scenarios.opendrive.lanes import LaneSection, is_for_side, read_section
from vpf_sim.scenarios.opendrive.xml_file import Element, integer, number
from vpf_sim.scenarios.parts import MOST_ROAD_M

START_M = 0.01  # of s: a section may begin so far outside of the road


class Link(NamedTuple):
    """What a road's end is connected to: a road, or a junction's choice of roads."""

    is_junction: bool
    id: str
    at_start: bool | None  # of the other road; none if the map does not say


class Connection(NamedTuple):
    """A connection through a junction: the road that it leads to, and the links of its lanes, from and to."""

    road: str
    at_start: bool | None
    links: list[Element]
    keys: tuple[str, str]
    where: str

    def lanes(self) -> dict[int, int]:
        """The lanes of the road that it leads to, by those of the road that it comes from."""
        here, there = self.keys
        return {integer(one, here, self.where): integer(one, there, self.where) for one in self.links}


class MapRoad:
    """A `<road>`: its reference line, lanes and links."""

    def __init__(self, element: Element, file: str) -> None:
        self.id = element.get("id", "")
        self.where = f"{file}: road {self.id}"
        self.is_left_hand = element.get("rule", "").upper() == "LHT"
        self._element = element
        self._sections: dict[bool, list[LaneSection]] = {}  # by side

    @cached_property
    def geometries(self) -> list[Geometry]:
        """The pieces of the reference line; those without a length are left out."""
        found = [
            read_geometry(one, f"{self.where}: planView.geometry[{i}]")
            for i, one in enumerate(self._element.findall("planView/geometry"))
            if number(one, "length", f"{self.where}: planView.geometry[{i}]") > 0.0
        ]
        if not found:
            raise InputError(f"{self.where}: planView: expected one or more geometries with a length, got none")
        starts = [one.s_m for one in found]
        if starts[0] < 0.0 or starts != sorted(starts) or found[-1].s_m + found[-1].length_m > MOST_ROAD_M:
            raise InputError(
                f"{self.where}: planView: expected geometries with s that grows from 0 to {MOST_ROAD_M:g} m at most, "
                f"got {shown(starts)}"
            )
        return found

    @property
    def length_m(self) -> float:
        return self.geometries[-1].s_m + self.geometries[-1].length_m

    @cached_property
    def lane_offsets(self) -> list[Cubic]:
        """How far the lanes are shifted to the left of the reference line."""
        return read_cubics(self._element.findall("lanes/laneOffset"), "s", f"{self.where}: lanes.laneOffset")

    def sections(self, left: bool) -> list[LaneSection]:
        """The lane sections of one side, in the order of s."""
        if left not in self._sections:
            self._sections[left] = self._read_sections(left)
        return self._sections[left]

    def _read_sections(self, left: bool) -> list[LaneSection]:
        where = f"{self.where}: lanes.laneSection"
        elements = [
            (i, one) for i, one in enumerate(self._element.findall("lanes/laneSection")) if is_for_side(one, left)
        ]
        given = [number(one, "s", f"{where}[{i}]") for i, one in elements]
        starts = [min(max(s, 0.0), self.length_m) for s in given]
        is_inside = all(abs(s - start) <= START_M for s, start in zip(given, starts, strict=True))
        if not is_inside or starts != sorted(starts) or starts[:1] > [START_M] or not starts:
            raise InputError(
                f"{self.where}: lanes: expected sections with s that grows from 0 to the road's length "
                f"{self.length_m:g}, got {shown(given)}"
            )
        return [
            read_section(one, start, end, left, f"{where}[{i}]")
            for (i, one), start, end in zip(elements, starts, [*starts[1:], self.length_m], strict=True)
        ]

    def link(self, at_end: bool) -> Element | None:
        """The link of the road's end, or of its start."""
        return self._element.find(f"link/{'successor' if at_end else 'predecessor'}")


class Network:
    """An OpenDRIVE map."""

    def __init__(self, path: Path, where: str) -> None:
        root = xml_file.read(path, where)
        self.file = str(path)
        self.roads = {road.id: road for road in (MapRoad(one, self.file) for one in root.findall("road"))}
        self._junctions = {one.get("id", ""): one for one in root.findall("junction")}

    def link(self, road: MapRoad, at_end: bool) -> Link | None:
        """What follows a road's end, or comes before its start; none if the map does not have it."""
        element = road.link(at_end)
        if element is None:
            return None
        name, kind = element.get("elementId", ""), element.get("elementType", "").lower()
        is_junction = kind == "junction" if kind else name not in self.roads
        known = self._junctions if is_junction else self.roads
        return Link(is_junction, name, _at_start(element)) if name in known else None

    def connections(self, junction: str, road: str) -> list[Connection]:
        """The connections into a junction from a road; those to the same end of a road are one."""
        element = self._junctions[junction]
        found: dict[tuple[str, bool | None, tuple[str, str]], list[Element]] = defaultdict(list)
        for one in element.findall("connection"):
            incoming, at_start = one.get("incomingRoad", ""), _at_start(one)
            linked = one.get("linkedRoad")  # the roads of a direct junction touch; it is driven both ways
            to = one.get("connectingRoad") if linked is None else linked
            if to in self.roads and incoming == road:
                found[to, at_start, ("from", "to")] += one.findall("laneLink")
            elif incoming in self.roads and linked == road:
                found[incoming, None, ("to", "from")] += one.findall("laneLink")
        where = f"{self.file}: junction {junction}: laneLink"
        return [Connection(to, at_start, links, keys, where) for (to, at_start, keys), links in found.items()]


def _at_start(element: Element) -> bool | None:
    """Whether a link touches the other road's start."""
    return {"start": True, "end": False}.get(element.get("contactPoint", "").lower())
