"""The route through a map: a list of roads, or the fewest roads between two."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from textwrap import shorten
from typing import NamedTuple

from vpf_sim.errors import MOST_NAMES_LENGTH, InputError, unknown_name
from vpf_sim.scenarios.opendrive.lanes import LaneSection
from vpf_sim.scenarios.opendrive.network import MapRoad, Network
from vpf_sim.scenarios.opendrive.road_section import OpenDriveRoad

Track = tuple[int, ...]  # a lane's id in each section of the route


class Leg(NamedTuple):
    """A road driven along its s, or against it."""

    road: MapRoad
    forward: bool

    @property
    def is_left(self) -> bool:
        """Whether it is driven on the left side of the reference line."""
        return self.forward == self.road.is_left_hand

    @property
    def sections(self) -> list[LaneSection]:
        """In the order of the drive."""
        sections = self.road.sections(self.is_left)
        return sections if self.forward else sections[::-1]

    def lanes(self, section: LaneSection) -> list[int]:
        """The drivable lanes of the drive's side, from the right."""
        outwards = section.drivable(self.is_left)
        return outwards if self.road.is_left_hand else outwards[::-1]

    @property
    def is_drivable(self) -> bool:
        return all(self.lanes(section) for section in self.sections)


def next_legs(network: Network, leg: Leg) -> list[Leg]:
    """All roads that a road leads to, whether or not they have lanes in the drive's direction."""
    link = network.link(leg.road, at_end=leg.forward)
    if link is None:
        return []
    if not link.is_junction:
        return _ends(network, leg, link.id, link.at_start)
    found = [
        one
        for connection in network.connections(link.id, leg.road.id)
        for one in _ends(network, leg, connection.road, connection.at_start)
    ]
    return [one for one in dict.fromkeys(found) if _comes_from(network, one, leg)]


def _ends(network: Network, leg: Leg, name: str, at_start: bool | None) -> list[Leg]:
    """A road from the end that touches a leg; where the map does not say which, from those that lead back."""
    road = network.roads[name]
    if at_start is not None:
        return [Leg(road, at_start)]
    return [one for one in (Leg(road, True), Leg(road, False)) if _comes_from(network, one, leg)]


def _comes_from(network: Network, leg: Leg, before: Leg) -> bool:
    """Whether a road begins at this end of the road before: both ends may be at the same junction."""
    link = network.link(leg.road, at_end=not leg.forward)
    if link is None or link.is_junction:
        return link is None or link[:2] == (network.link(before.road, at_end=before.forward) or link)[:2]
    return link.id == before.road.id and link.at_start in (None, not before.forward)


def lanes_between(network: Network, leg: Leg, after: Leg) -> dict[int, int]:
    """The lane of the next road for each lane of a road that goes on."""
    link = network.link(leg.road, at_end=leg.forward)
    given: dict[int, int] = {}
    if link is not None and link.is_junction:
        ways = [way for way in network.connections(link.id, leg.road.id) if way.road == after.road.id]
        given = next((way.lanes() for way in ways if way.at_start in (None, after.forward)), {})
    return _joined((leg, leg.sections[-1]), (after, after.sections[0]), given)


def lanes_within(leg: Leg, section: LaneSection, after: LaneSection) -> dict[int, int]:
    """The lane of the next section for each lane of a section that goes on."""
    return _joined((leg, section), (leg, after), {})


Side = tuple[Leg, LaneSection]


def _joined(before: Side, after: Side, given: Mapping[int, int]) -> dict[int, int]:
    """Lanes by the links given, else by those of the lanes; without any, by their order from the right."""
    (leg, section), (next_leg, next_section) = before, after
    lanes, next_lanes = leg.lanes(section), next_leg.lanes(next_section)
    back = _links(next_lanes, next_section, not next_leg.forward)
    for pairs in (given.items(), _links(lanes, section, leg.forward), ((here, there) for there, here in back)):
        known = [(here, there) for here, there in pairs if here in section.lanes and there in next_section.lanes]
        if known:
            return _one_to_one([(here, there) for here, there in known if here in lanes and there in next_lanes])
    return dict(zip(lanes, next_lanes, strict=False))


def _links(lanes: Sequence[int], section: LaneSection, to_successor: bool) -> Iterator[tuple[int, int]]:
    return ((here, there) for here in lanes for there in section.lanes[here].linked(to_successor))


def _one_to_one(pairs: Sequence[tuple[int, int]]) -> dict[int, int]:
    """The first pair of each lane before and of each lane after."""
    joined: dict[int, int] = {}
    for here, there in pairs:
        if here not in joined and there not in joined.values():
            joined[here] = there
    return joined


class Route(NamedTuple):
    """Roads in order, and the lanes that run through all of them, from the right."""

    legs: tuple[Leg, ...]
    tracks: tuple[Track, ...]


def find_route(network: Network, wanted: OpenDriveRoad, file: str) -> Route:
    """The route of a scenario file; `file` is its name in messages."""
    keys = [f"route[{i}]" for i in range(len(wanted.route))] or ["from", "to"]
    ids = wanted.route or (wanted.start or "", wanted.to or "")
    for key, name in zip(keys, ids, strict=True):
        if name not in network.roads:
            raise InputError(f"{file}: road.{key}: {unknown_name(f'road of {network.file}', name, network.roads)}")
    starts = _starts(network, ids[0], wanted.direction, f"{file}: road")
    if not wanted.route:
        return _shortest(network, starts, ids[1], f"{file}: road.to")
    found = _along(network, starts, ids[1:], file)
    if len(found) > 1:
        raise InputError(
            f"{file}: road.direction: expected forward or backward, as the route can be driven both ways, got none"
        )
    return found[0]


def _starts(network: Network, name: str, direction: str | None, where: str) -> list[Route]:
    """The first road in each direction that is possible."""
    road = network.roads[name]
    legs = [Leg(road, forward) for forward in (True, False)]
    drivable = [leg for leg in legs if leg.is_drivable]
    if not drivable:
        raise InputError(f"{road.where}: lanes: expected a driving lane along the whole road, got none")
    chosen = [leg for leg in drivable if direction in (None, "forward" if leg.forward else "backward")]
    if not chosen:
        other = "forward" if direction == "backward" else "backward"
        raise InputError(
            f"{where}.direction: expected {other}, as road {name} has no driving lanes the other way, got {direction}"
        )
    return [_extended(Route((), ()), leg, None) for leg in chosen]


def _extended(route: Route, leg: Leg, lanes: dict[int, int] | None) -> Route:
    """A route with one more road; `lanes` leads to it from the road before."""
    sections = leg.sections
    if lanes is None:
        tracks: list[Track] = [(lane,) for lane in leg.lanes(sections[0])]
    else:
        tracks = [(*track, lanes[track[-1]]) for track in route.tracks if track[-1] in lanes]
    for section, after in pairwise(sections):
        lanes = lanes_within(leg, section, after)
        tracks = [(*track, lanes[track[-1]]) for track in tracks if track[-1] in lanes]
    return Route((*route.legs, leg), tuple(tracks))


def _onward(network: Network, route: Route, leg: Leg) -> Route:
    """A route with a road that its last one leads to."""
    return _extended(route, leg, lanes_between(network, route.legs[-1], leg))


def _along(network: Network, starts: list[Route], ids: Sequence[str], file: str) -> list[Route]:
    """The routes from the starts along the roads of a list."""
    routes = _with_lanes(starts)
    for i, name in enumerate(ids, start=1):
        ahead = [(route, leg) for route in routes for leg in next_legs(network, route.legs[-1])]
        found = [(route, leg) for route, leg in ahead if leg.road.id == name and leg.is_drivable]
        if not found:
            names = sorted({leg.road.id for _, leg in ahead if leg.road.id != name})
            raise InputError(
                f"{file}: road.route[{i}]: expected a road that road {routes[0].legs[-1].road.id} leads to, "
                f"one of {shorten(', '.join(names), MOST_NAMES_LENGTH) or 'none'}, got {name!r}"
            )
        routes = _with_lanes([_onward(network, route, leg) for route, leg in found])
    return routes


def _with_lanes(routes: Sequence[Route]) -> list[Route]:
    """Those on which a lane runs through up to the last road."""
    found = [route for route in routes if route.tracks]
    if not found:
        road = routes[0].legs[-1].road
        raise InputError(f"{road.where}: lanes: expected a driving lane that runs through all of the route, got none")
    return found


def _shortest(network: Network, starts: Sequence[Route], to: str, where: str) -> Route:
    """The route of the fewest roads on which a lane runs through, by breadth-first search."""
    front, seen = [start for start in starts if start.tracks], set()
    faults: list[str] = []
    while front:
        for route in front:
            if route.legs[-1].road.id == to:
                return route
        reached, front = [one for route in front for one in _ahead(network, route, faults)], []
        for route in reached:
            state = (route.legs[-1].road.id, route.legs[-1].forward, tuple(track[-1] for track in route.tracks))
            if state not in seen:
                seen.add(state)
                front.append(route)
    ids = [start.legs[0].road.id for start in starts]
    raise InputError(
        f"{where}: expected a road that a lane leads to from road {ids[0]}, without lane changes, got {to!r}"
        + (f"; left out: {faults[0]}" if faults else "")
    )


def _ahead(network: Network, route: Route, faults: list[str]) -> Iterator[Route]:
    """A route with each road that a lane leads to; those with faults are left out and reported."""
    for leg in next_legs(network, route.legs[-1]):
        try:
            longer = _onward(network, route, leg) if leg.is_drivable else None
        except InputError as error:
            faults.append(str(error))
            continue
        if longer is not None and longer.tracks:
            yield longer
