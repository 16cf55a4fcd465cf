"""The roads and junctions of an OpenDRIVE map; a road is read when it is needed."""

from collections import defaultdict
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from vpf_sim.errors import InputError, shown
from vpf_sim.scenarios.opendrive import xml_file
from vpf_sim.scenarios.opendrive.cubics import Cubic, read_cubics
from vpf_sim.scenarios.opendrive.geometry import Geometry, read_geometry
from vpf_sim.scenarios.opendrive.lanes import LaneSection, read_section
from vpf_sim.scenarios.opendrive.xml_file import Element, integer, number
from vpf_sim.scenarios.parts import MOST_ROAD_M

START_M = 0.01  # of s: a first section may begin so far from 0


class Link(NamedTuple):
    """What a road's end is connected to: a road, or a junction's choice of roads."""

    is_junction: bool
    id: str
    at_start: bool  # of the other road


class Connection(NamedTuple):
    """A way into a junction: the road that leads through it, and its lanes by those of the incoming road."""

    road: str
    at_start: bool
    lanes: dict[int, int]


class MapRoad:
    """A `<road>`: its reference line, lanes and links."""

    def __init__(self, element: Element, file: str) -> None:
        self.id = element.get("id", "")
        self.where = f"{file}: road {self.id}"
        self.is_left_hand = element.get("rule") == "LHT"
        self._element = element

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

    @cached_property
    def sections(self) -> list[LaneSection]:
        elements = self._element.findall("lanes/laneSection")
        where = f"{self.where}: lanes.laneSection"
        starts = [number(one, "s", f"{where}[{i}]") for i, one in enumerate(elements)]
        ends = [*starts[1:], self.length_m]
        if (
            not elements
            or abs(starts[0]) > START_M
            or any(start >= end for start, end in zip(starts, ends, strict=True))
        ):
            raise InputError(
                f"{self.where}: lanes: expected sections with s that grows from 0 to the road's length "
                f"{self.length_m:g}, got {shown(starts)}"
            )
        return [
            read_section(one, start, end, f"{where}[{i}]")
            for i, (one, start, end) in enumerate(zip(elements, starts, ends, strict=True))
        ]

    def link(self, at_end: bool) -> Link | None:
        """What follows the road's end, or comes before its start."""
        element = self._element.find(f"link/{'successor' if at_end else 'predecessor'}")
        if element is None:
            return None
        is_junction = element.get("elementType") == "junction"
        return Link(is_junction, element.get("elementId", ""), element.get("contactPoint") != "end")


class Network:
    """An OpenDRIVE map."""

    def __init__(self, path: Path, where: str) -> None:
        root = xml_file.read(path, where)
        self.file = str(path)
        self.roads = {road.id: road for road in (MapRoad(one, self.file) for one in root.findall("road"))}
        self._junctions = {one.get("id", ""): one for one in root.findall("junction")}

    def road(self, name: str, from_road: MapRoad) -> MapRoad:
        """A road that another one names."""
        if name not in self.roads:
            raise InputError(f"{from_road.where}: link: expected the id of a road, got {shown(name)}")
        return self.roads[name]

    def connections(self, junction: str, incoming: str) -> list[Connection]:
        """The ways into a junction from a road; ways along the same road are one."""
        element = self._junctions.get(junction)
        lanes: dict[tuple[str, bool], dict[int, int]] = defaultdict(dict)
        for one in [] if element is None else element.findall("connection"):
            if one.get("incomingRoad") == incoming and one.get("connectingRoad") is not None:
                where = f"{self.file}: junction {junction}: connection {one.get('id')}.laneLink"
                pairs = [(integer(x, "from", where), integer(x, "to", where)) for x in one.findall("laneLink")]
                lanes[one.get("connectingRoad", ""), one.get("contactPoint") != "end"].update(pairs)
        return [Connection(road, at_start, pairs) for (road, at_start), pairs in lanes.items()]
