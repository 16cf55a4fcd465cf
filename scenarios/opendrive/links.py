"""Where a drive can go on at the end of a road, and which lanes lead there."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from vpf_sim.scenarios.opendrive.lanes import LaneSection
from vpf_sim.scenarios.opendrive.network import MapRoad, Network


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
    ways = network.connections(link.id, leg.road.id)
    found = [one for way in ways for one in _ends(network, leg, way.road, way.at_start)]
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
