"""The world of an episode: road, route, ego, and traffic that comes and goes."""

from dataclasses import dataclass
from math import radians
from typing import Protocol

import numpy as np
from highway_env.road.road import Road

from vpf_sim.envs.actor import place_objects
from vpf_sim.envs.ego import Ego
from vpf_sim.envs.road import build_road, centre_line
from vpf_sim.envs.route import Route
from vpf_sim.scenarios import DrawnScenario, HighwayScenario, Scenario
from vpf_sim.seeding import stream


class Traffic(Protocol):
    """Objects that are moved in their own way."""

    def advance(self, steps: int, rate_hz: float) -> None:
        """One step of the road with all on it, after `steps` others."""
        ...


@dataclass(frozen=True, slots=True)
class World:
    """A road with its objects and the ego, and the route over it."""

    road: Road
    route: Route
    ego: Ego
    traffic: Traffic | None = None

    def advance(self, steps: int, rate_hz: float) -> None:
        """One step of the road with all on it, after `steps` others."""
        if self.traffic is not None:
            self.traffic.advance(steps, rate_hz)
            return
        self.road.act()
        self.road.step(1.0 / rate_hz)


def build_world(scenario: DrawnScenario, seed: int, friction: float | None = None) -> World:
    """The world of a scenario as a seed draws it, with the road's coefficient of friction."""
    if isinstance(scenario, HighwayScenario):
        from vpf_sim.envs.highway.traffic import build

        traffic, route, ego = build(scenario, seed, friction)
        return World(traffic.road, route, ego, traffic)
    road = build_road(scenario, stream(seed, "road"))
    route = Route.of(road.network.centre, scenario)
    place_objects(road, scenario)
    start = scenario.ego
    position = np.array(route.centre.position_at(start.s_m, route.offset_at(start.s_m) + start.lateral_m))
    heading = route.centre.heading_at(start.s_m) + radians(start.heading_deg)
    ego = Ego(road, position, heading, start.speed_mps, friction)
    road.vehicles.append(ego)
    return World(road, route, ego)


def build_route(scenario: DrawnScenario, seed: int) -> Route:
    """The route of a scenario as a seed draws it."""
    if isinstance(scenario, Scenario):
        return Route.of(centre_line(scenario.road), scenario)
    return build_world(scenario, seed).route
