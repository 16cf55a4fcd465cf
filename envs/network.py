"""What the ego, the endings and the scores read of a road and of the objects on it.

A place is (s, lateral): metres along the road's reference line, and metres right of it. Every object on a road has one;
it is nan where the reference line does not pass the object.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

from highway_env.road.road import LaneIndex

from vpf_sim.envs.centre_line import ReferenceLine
from vpf_sim.scenarios.kinds import ObjectKind
from vpf_sim.types import Floats

Point = tuple[float, float]  # m, in world axes
Place = tuple[float, float]


class Outline(Protocol):
    """A rectangle on the ground, in world axes."""

    position: Floats  # (2,) m, its centre
    heading: float  # rad
    LENGTH: float  # m
    WIDTH: float  # m


class OnRoad(Outline, Protocol):
    """A car or another object on a road."""

    kind: ObjectKind
    place: Place
    speed: float  # m/s
    crashed: bool
    road: "PopulatedRoad"

    @property
    def velocity(self) -> Floats:
        """(2,) m/s."""
        ...

    @property
    def diagonal(self) -> float:
        """The outline's diagonal, m."""
        ...


class LaneUse(NamedTuple):
    """How the corners of a car lie on the lanes."""

    is_outside: bool  # a corner is on no lane
    in_one_lane: bool  # one lane holds all corners


class RoadLines(NamedTuple):
    """A road from above, in world axes."""

    strips_m: tuple[tuple[Floats, Floats], ...]  # the surface: (M, 2) left and right sides of each strip
    solid_m: tuple[Floats, ...]  # (M, 2) each
    dashed_m: tuple[Floats, ...]  # (M, 2) each


class Network(Protocol):
    """A highway-env road network that knows places and edges."""

    centre: ReferenceLine

    def place_at(self, x_m: float, y_m: float, near_s_m: float | None = None) -> Place:
        """The place of a world point; `near_s_m` is about where it is, if that is known."""
        ...

    def lane_of(self, ego: OnRoad) -> LaneIndex:
        """The index of the lane in which the ego is."""
        ...

    def get_lane(self, index: LaneIndex) -> Any:
        """The lane with an index."""
        ...

    def is_off_road(self, ego: OnRoad) -> bool:
        """Whether the ego has left the road, which ends the episode."""
        ...

    def lane_use(self, corners: Sequence[Point], near_s_m: float) -> LaneUse:
        """How the corners of a car, which is near s, lie on the lanes."""
        ...

    def edges_at(self, x_m: float, y_m: float, heading_rad: float) -> tuple[float, float]:
        """(left, right) m, offsets from a point to the edges of the carriageway, left < 0; nan where it has no edge."""
        ...

    def lines(self) -> RoadLines:
        """The road from above."""
        ...


class PopulatedRoad(Protocol):
    """A road with all that is on it."""

    network: Network
    vehicles: list[OnRoad]  # they move by themselves
    objects: list[OnRoad]
