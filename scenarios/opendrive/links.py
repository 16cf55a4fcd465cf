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
        return self.road.sections if self.forward else self.road.sections[::-1]

    def lanes(self, section: LaneSection) -> list[int]:
        """The drivable lanes of the drive's side, from the right."""
        outwards = section.drivable(self.is_left)
        return outwards if self.road.is_left_hand else outwards[::-1]

    @property
    def is_drivable(self) -> bool:
        return all(self.lanes(section) for section in self.sections)


def next_legs(network: Network, leg: Leg) -> list[Leg]:
    """All roads that a road leads to and that have lanes in the drive's direction."""
    link = leg.road.link(at_end=leg.forward)
    if link is None:
        return []
    if not link.is_junction:
        found = [Leg(network.road(link.id, leg.road), link.at_start)]
    else:
        ways = network.connections(link.id, leg.road.id)
        legs = [Leg(network.road(way.road, leg.road), way.at_start) for way in ways]
        found = [one for one in legs if _comes_from(one, leg)]
    return [one for one in found if one.is_drivable]


def _comes_from(leg: Leg, before: Leg) -> bool:
    """Whether a junction's road begins at this end of the road before: both ends may be at the same junction."""
    link = leg.road.link(at_end=not leg.forward)
    return link is None or link.is_junction or link == (False, before.road.id, not before.forward)


def lanes_between(network: Network, leg: Leg, after: Leg) -> dict[int, int]:
    """The lane of the next road for each lane of a road that goes on."""
    link = leg.road.link(at_end=leg.forward)
    given: dict[int, int] = {}
    if link is not None and link.is_junction:
        ways = network.connections(link.id, leg.road.id)
        given = next((way.lanes for way in ways if (way.road, way.at_start) == (after.road.id, after.forward)), {})
    return _joined((leg, leg.sections[-1]), (after, after.sections[0]), given)


def lanes_within(leg: Leg, section: LaneSection, after: LaneSection) -> dict[int, int]:
    """The lane of the next section for each lane of a section that goes on."""
    return _joined((leg, section), (leg, after), {})


Side = tuple[Leg, LaneSection]


def _joined(before: Side, after: Side, given: Mapping[int, int]) -> dict[int, int]:
    """Lanes by the links given, else by those of the lanes; without any, by their order from the right."""
    (leg, section), (next_leg, next_section) = before, after
    lanes, next_lanes = leg.lanes(section), next_leg.lanes(next_section)
    pairs = [*given.items()] or [*_links(lanes, section, leg.forward)]
    pairs = pairs or [(there, here) for here, there in _links(next_lanes, next_section, not next_leg.forward)]
    pairs = pairs or [*zip(lanes, next_lanes, strict=False)]
    return _one_to_one([(here, there) for here, there in pairs if here in lanes and there in next_lanes])


def _links(lanes: Sequence[int], section: LaneSection, to_successor: bool) -> Iterator[tuple[int, int]]:
    for here in lanes:
        lane = section.lanes[here]
        for there in lane.successors if to_successor else lane.predecessors:
            yield here, there


def _one_to_one(pairs: Sequence[tuple[int, int]]) -> dict[int, int]:
    """The first pair of each lane before and of each lane after."""
    joined: dict[int, int] = {}
    for here, there in pairs:
        if here not in joined and there not in joined.values():
            joined[here] = there
    return joined
