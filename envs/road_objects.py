"""Static obstacles and traffic actors on the road: one class per kind, since highway-env takes sizes from the class."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import Obstacle, RoadObject

from vpf_sim.envs.rectangles import solid_objects
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.kinds import MOVING, SIZES, ObjectKind
from vpf_sim.types import Floats

MAX_ACCELERATION_MPS2 = 1.5
COMFORTABLE_BRAKING_MPS2 = 2.0
FULL_BRAKING_MPS2 = 6.0
TIME_GAP_S = 1.5
STANDING_GAP_M = 2.0
CLOSING_SCALE_MPS2 = 2.0 * math.sqrt(MAX_ACCELERATION_MPS2 * COMFORTABLE_BRAKING_MPS2)
SIDE_GAP_M = 0.2  # lateral gap below which an object ahead is a leader


class StaticObstacle(Obstacle):  # type: ignore[misc]
    """A static obstacle; it belongs in `road.objects`."""

    kind: ObjectKind
    HEIGHT: float

    def __init__(self, road: Road, place: tuple[float, float]) -> None:
        self.place = place  # s, lateral on the carriageway
        centre = road.network.centre
        super().__init__(road, centre.position_at(*place), centre.heading_at(place[0]))


class Actor(Vehicle):  # type: ignore[misc]
    """A traffic actor that keeps its lane position and its speed, and follows a leader by the Intelligent Driver Model.

    Treiber, Hennecke, Helbing, Phys. Rev. E 62, 2000, with the gap from bumper to bumper:
    a [1 - (v / v0)^4 - (s* / gap)^2], s* = s0 + v T + v dv / (2 sqrt(a b)). It never reverses. It moves exactly along
    the lane, so contacts do not displace it and it cannot leave the road.
    """

    kind: ObjectKind
    HEIGHT: float
    position: Floats  # (2,) m
    heading: float  # rad
    speed: float  # m/s

    def __init__(self, road: Road, place: tuple[float, float], speed: float) -> None:
        self.place = place  # s, lateral on the carriageway
        centre = road.network.centre
        super().__init__(road, centre.position_at(*place), centre.heading_at(place[0]), speed)
        self.target_speed = speed

    def act(self, action: object = None) -> None:  # noqa: ARG002
        """Set the acceleration; the argument is ignored."""
        acceleration = 1.0 - (self.speed / self.target_speed) ** 4
        gap_m, leader = self._leader()
        if leader is not None:
            closing_mps = self.speed - float(leader.velocity @ self.direction)
            wanted_m = STANDING_GAP_M + self.speed * max(0.0, TIME_GAP_S + closing_mps / CLOSING_SCALE_MPS2)
            acceleration -= (wanted_m / max(gap_m, 0.1)) ** 2
        acceleration = max(MAX_ACCELERATION_MPS2 * acceleration, -FULL_BRAKING_MPS2)
        self.action = {"steering": 0.0, "acceleration": -FULL_BRAKING_MPS2 if self.crashed else acceleration}

    def _leader(self) -> tuple[float, RoadObject | None]:
        """The gap, bumper to bumper, to the nearest object ahead in the actor's path, and that object."""
        nearest_m, leader = math.inf, None
        s, lateral = self.place
        for other in solid_objects(self):
            other_s, other_lateral = other.place
            side_m = abs(other_lateral - lateral) - (self.WIDTH + other.WIDTH) / 2.0
            gap_m = other_s - s - (self.LENGTH + other.LENGTH) / 2.0
            if other_s > s and side_m < SIDE_GAP_M and gap_m < nearest_m:
                nearest_m, leader = gap_m, other
        return nearest_m, leader

    def step(self, dt: float) -> None:
        """Move along the lane for dt seconds."""
        before_mps = self.speed
        self.speed = max(before_mps + self.action["acceleration"] * dt, 0.0)
        s, lateral = self.place
        centre = self.road.network.centre
        s += 0.5 * (before_mps + self.speed) * dt / (1.0 - lateral * centre.curvature_at(s))
        self.place = (s, lateral)
        self.position = np.array(centre.position_at(s, lateral))
        self.heading = centre.heading_at(s)
        self.impact = None

    def on_state_update(self) -> None:
        """Nothing to update: the lane never changes."""


def _class_by_kind(base: type[RoadObject], kinds: Iterable[ObjectKind]) -> dict[ObjectKind, type[Any]]:
    """A subclass per kind: sizes set on an instance would leave highway-env's `diagonal` stale."""
    return {
        kind: type(
            f"{base.__name__}{kind.capitalize()}",
            (base,),
            {
                "__doc__": f"A {kind}.",
                "__module__": __name__,
                "kind": kind,
                "LENGTH": SIZES[kind].length_m,
                "WIDTH": SIZES[kind].width_m,
                "HEIGHT": SIZES[kind].height_m,
            },
        )
        for kind in kinds
    }


STATIC_OBSTACLES = _class_by_kind(StaticObstacle, SIZES)
ACTORS = _class_by_kind(Actor, MOVING)
# pickle looks classes up by their name in the module
globals().update({cls.__name__: cls for cls in (*STATIC_OBSTACLES.values(), *ACTORS.values())})


def place_objects(road: Road, scenario: Scenario) -> None:
    """Put the objects of a scenario on its road, along their lanes."""
    for obj in scenario.bodies:
        place = (obj.s_m, scenario.road.lane_offset_m(obj.lane) + obj.lateral_m)
        if obj.speed_mps > 0.0:
            road.vehicles.append(ACTORS[obj.kind](road, place, obj.speed_mps))
        else:
            road.objects.append(STATIC_OBSTACLES[obj.kind](road, place))
