"""The objects on a road: one class per kind, since highway-env takes sizes from the class."""

import math
from collections.abc import Iterable
from typing import Any

from highway_env.road.road import Road
from highway_env.vehicle.objects import Obstacle, RoadObject

from vpf_sim.envs.actor import Actor
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.kinds import MOVING, SIZES, ObjectKind


class StaticObstacle(Obstacle):  # type: ignore[misc]
    """A static obstacle; it belongs in `road.objects`."""

    kind: ObjectKind
    HEIGHT: float

    def __init__(self, road: Road, place: tuple[float, float], oncoming: bool = False) -> None:
        self.place = place  # s, lateral on the carriageway
        centre = road.network.centre
        super().__init__(road, centre.position_at(*place), centre.heading_at(place[0]) + (math.pi if oncoming else 0.0))
        self.check_collisions = False  # what moves checks


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
        lane_m = scenario.road.lane_offset_m(obj.lane, obj.s_m)
        place = (obj.s_m, lane_m + obj.lateral_m)
        if obj.is_actor:
            actor = ACTORS[obj.kind](road, place, obj.speed_mps, obj.oncoming, obj.manoeuvres, lane_m, obj.lane)
            road.vehicles.append(actor)
        else:
            road.objects.append(STATIC_OBSTACLES[obj.kind](road, place, obj.oncoming))
