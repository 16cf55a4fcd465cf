"""Traffic actors: they keep lane and speed, follow a leader, and carry out the manoeuvres of a scenario."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import Obstacle, RoadObject

from vpf_sim.envs.contacts import solid_objects
from vpf_sim.envs.ego import Ego
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.kinds import MOVING, SIZES, ObjectKind
from vpf_sim.scenarios.parts import Manoeuvre
from vpf_sim.types import Floats

MAX_ACCELERATION_MPS2 = 1.5
COMFORTABLE_BRAKING_MPS2 = 2.0
FULL_BRAKING_MPS2 = 6.0
TIME_GAP_S = 1.5
STANDING_GAP_M = 2.0
CLOSING_SCALE_MPS2 = 2.0 * math.sqrt(MAX_ACCELERATION_MPS2 * COMFORTABLE_BRAKING_MPS2)
SIDE_GAP_M = 0.2  # lateral gap below which an object ahead is a leader


class Actor(Vehicle):  # type: ignore[misc]
    """A traffic actor that keeps its lane position and its speed, and follows a leader by the Intelligent Driver Model.

    Treiber, Hennecke, Helbing, Phys. Rev. E 62, 2000, with the gap from bumper to bumper:
    a [1 - (v / v0)^4 - (s* / gap)^2], s* = s0 + v T + v dv / (2 sqrt(a b)). It never reverses. It moves exactly along
    the lane, so contacts do not displace it and it cannot leave the road.

    A manoeuvre gives it another speed, which it reaches at a constant rate, or another lateral position,
    to which it moves at a constant speed. While it moves to the side it faces its direction of motion, and
    does not yield; along the road it follows its leader as before. Contact stops it.
    """

    kind: ObjectKind
    HEIGHT: float
    position: Floats  # (2,) m
    heading: float  # rad
    speed: float  # m/s

    def __init__(
        self,
        road: Road,
        place: tuple[float, float],
        speed: float,
        oncoming: bool = False,
        manoeuvres: Sequence[Manoeuvre] = (),
        lane_m: float = 0.0,
        lane: int = 1,
    ) -> None:
        """`lane_m` is the middle of lane number `lane`, from which manoeuvres count their lateral position."""
        self.place = place  # s, lateral on the carriageway
        self._forward = -1.0 if oncoming else 1.0
        self._turn_rad = math.pi if oncoming else 0.0  # heading to the road's
        self._along_mps = speed
        self._rate_mps2: float | None = None  # of a manoeuvre
        self._lane_m, self._lane = lane_m, lane
        self._lateral_m, self._lateral_mps = place[1], 0.0  # wanted
        self._waiting, self._waited_s = list(manoeuvres), 0.0
        centre = road.network.centre
        super().__init__(road, centre.position_at(*place), centre.heading_at(place[0]) + self._turn_rad, speed)
        self.target_speed = speed
        self.check_collisions = self.kind != "door"  # it touches the car that it belongs to; the ego checks

    def act(self, action: object = None) -> None:  # noqa: ARG002
        """Begin the manoeuvre that is due, and set the acceleration; the argument is ignored."""
        while self._waiting and self._is_due(self._waiting[0]):
            self._begin(self._waiting.pop(0))
        share = self._towards_target()
        gap_m, leader = self._leader()
        if leader is not None:
            closing_mps = self._along_mps - float(leader.velocity @ self.direction)
            wanted_m = STANDING_GAP_M + self._along_mps * max(0.0, TIME_GAP_S + closing_mps / CLOSING_SCALE_MPS2)
            share -= (wanted_m / max(gap_m, 0.1)) ** 2
        acceleration = max(MAX_ACCELERATION_MPS2 * share, -max(FULL_BRAKING_MPS2, self._rate_mps2 or 0.0))
        self.action = {"steering": 0.0, "acceleration": -FULL_BRAKING_MPS2 if self.crashed else acceleration}

    def put_at(self, s_m: float) -> None:
        """Put it at another place along its lane; speed and manoeuvres stay."""
        self.place = (s_m, self.place[1] + self._follow_lane(s_m))
        self._set_pose()

    def step(self, dt: float) -> None:
        """Move for dt seconds."""
        self._waited_s += dt
        before_mps = self._along_mps
        self._along_mps = self._next_speed(dt)
        s, lateral = self.place
        centre = self.road.network.centre
        driven_m = 0.5 * (before_mps + self._along_mps) * dt
        s += self._forward * driven_m / (1.0 - lateral * centre.curvature_at(s))
        lateral += self._follow_lane(s)
        aside_m = 0.0 if self.crashed else min(abs(self._lateral_m - lateral), self._lateral_mps * dt)
        aside_mps = math.copysign(aside_m / dt, self._lateral_m - lateral)
        self.place = (s, lateral + aside_mps * dt)
        self.speed = math.hypot(self._along_mps, aside_mps)
        if self.speed > 0.0:  # at standstill it keeps its heading
            self._turn_rad = math.atan2(aside_mps, self._forward * self._along_mps)
        self._set_pose()
        self.impact = None

    def _follow_lane(self, s_m: float) -> float:
        """m, how far the middle of its lane is right of where it was; what is wanted moves with it."""
        places = getattr(self.road.network, "places", None)
        if places is None:
            return 0.0
        shift_m = float(places.middle(self._lane, s_m)) - self._lane_m
        self._lane_m += shift_m
        self._lateral_m += shift_m
        return shift_m

    def on_state_update(self) -> None:
        """Nothing to update: the lane never changes."""

    def _set_pose(self) -> None:
        """Position and heading in the world, by the place on the road."""
        centre = self.road.network.centre
        self.position = np.array(centre.position_at(*self.place))
        self.heading = centre.heading_at(self.place[0]) + self._turn_rad

    def _is_due(self, manoeuvre: Manoeuvre) -> bool:
        if manoeuvre.after_s is not None:
            return self._waited_s >= manoeuvre.after_s - 1e-9
        return self._free_road_m() <= (manoeuvre.within_m or 0.0)

    def _free_road_m(self) -> float:
        """m of road between the ego and this actor; inf without an ego."""
        gaps = (
            abs(other.place[0] - self.place[0]) - (self.LENGTH + other.LENGTH) / 2.0
            for other in self.road.vehicles
            if isinstance(other, Ego)
        )
        return min(gaps, default=math.inf)

    def _begin(self, manoeuvre: Manoeuvre) -> None:
        self._waited_s = 0.0
        if manoeuvre.speed_mps is not None:
            self.target_speed, self._rate_mps2 = manoeuvre.speed_mps, manoeuvre.rate_mps2
        if manoeuvre.lateral_m is not None:
            self._lateral_m, self._lateral_mps = self._lane_m + manoeuvre.lateral_m, manoeuvre.lateral_mps

    def _towards_target(self) -> float:
        """The acceleration on a free road, as a share of MAX_ACCELERATION_MPS2."""
        if self._rate_mps2 is not None:
            return math.copysign(self._rate_mps2 / MAX_ACCELERATION_MPS2, self.target_speed - self._along_mps)
        return 1.0 - (self._along_mps / self.target_speed) ** 4 if self.target_speed > 0.0 else 0.0

    def _next_speed(self, dt: float) -> float:
        """m/s along the road after dt; a manoeuvre's speed is reached exactly."""
        change_mps = self.action["acceleration"] * dt
        after_mps = max(self._along_mps + change_mps, 0.0)
        if self._rate_mps2 is None or self.crashed:
            return after_mps
        passed = (self._along_mps - self.target_speed) * (after_mps - self.target_speed) < 0.0
        if passed or (self._along_mps == self.target_speed and change_mps > 0.0):
            return self.target_speed
        return after_mps

    def _leader(self) -> tuple[float, RoadObject | None]:
        """The gap, bumper to bumper, to the nearest object ahead in the actor's path, and that object."""
        nearest_m, leader = math.inf, None
        s, lateral = self.place
        for other in solid_objects(self):
            other_s, other_lateral = other.place
            side_m = abs(other_lateral - lateral) - (self.WIDTH + other.WIDTH) / 2.0
            ahead_m = self._forward * (other_s - s)
            gap_m = ahead_m - (self.LENGTH + other.LENGTH) / 2.0
            if ahead_m > 0.0 and side_m < SIDE_GAP_M and gap_m < nearest_m:
                nearest_m, leader = gap_m, other
        return nearest_m, leader


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
