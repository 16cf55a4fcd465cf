"""The route through a map: a list of roads, or the fewest roads between two."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from textwrap import shorten
from typing import NamedTuple

from vpf_sim.errors import MOST_NAMES_LENGTH, InputError, unknown_name
from vpf_sim.scenarios.opendrive.keys import OpenDriveRoad
from vpf_sim.scenarios.opendrive.links import Leg, lanes_between, lanes_within, next_legs
from vpf_sim.scenarios.opendrive.network import Network

Track = tuple[int, ...]  # a lane's id in each section of the route


class Route(NamedTuple):
    """Roads in order, and the lanes that run through all of them, from the right."""

    legs: tuple[Leg, ...]
    tracks: tuple[Track, ...]


def find_route(network: Network, wanted: OpenDriveRoad, file: str) -> Route:
    """The route that a scenario file asks for; `file` is its name in messages."""
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
    """A route with each road that a lane leads to; those with faults are left out and told."""
    for leg in next_legs(network, route.legs[-1]):
        try:
            longer = _onward(network, route, leg) if leg.is_drivable else None
        except InputError as error:
            faults.append(str(error))
            continue
        if longer is not None and longer.tracks:
            yield longer
