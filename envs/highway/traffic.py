"""The world of a highway-env environment as it makes it, and the traffic that it lets come and go."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec, module_from_spec
from math import hypot, isnan, nan
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import load_env_creator
from highway_env.envs import IntersectionEnv
from highway_env.utils import class_from_path
from highway_env.vehicle.objects import Obstacle, RoadObject

from vpf_sim.envs.ego import Ego
from vpf_sim.envs.highway.indexed_road import speed_up
from vpf_sim.envs.highway.lane_graph import ROUTE_HALF_M, LaneGraph
from vpf_sim.envs.highway.lanes import Road, Stretch, roads_to, stretches
from vpf_sim.envs.highway.path import centre_line, forks
from vpf_sim.envs.network import Place
from vpf_sim.envs.route import BEYOND_GOAL_M, Fork, Route
from vpf_sim.scenarios import HighwayScenario
from vpf_sim.scenarios.highway import HighwayEnv

# An object that is farther beside the route (two lanes), or farther from the ego, has no place.
BESIDE_M, FAR_M = 8.0, 100.0
Parameters = dict[str, Any]  # of a class of cars, by name
NOWHERE: Place = (nan, nan)
# The id's own action has no planned route, and with it the destination that highway-env draws would be lost.
PLANNED = {"intersection-v1": {"action": {"type": "DiscreteMetaAction"}}}
DESTINATIONS = {"exit-v0": "exit", "exit-v1": "exit"}  # of ids that have one which highway-env does not plan
SPARE_M = 20.0  # lanes beyond the last waypoint


class Traffic:
    """A highway-env environment after its reset; only its road is driven on, never its `step`."""

    def __init__(self, settings: HighwayEnv, seed: int) -> None:
        config = {**settings.config.given(), **PLANNED.get(settings.id, {})}
        if config.get("destination") == "random":
            config["destination"] = None
        # its class, since gymnasium.make warns that a newer version of the environment exists
        environment: Any = load_env_creator(str(gymnasium.spec(settings.id).entry_point))
        self._kind = class_from_path({**environment.default_config(), **config}["other_vehicles_type"])
        with _as_written(self._kind) as parameters:
            self._env: Any = environment(config=config)
            self._env.reset(seed=seed)
        self._parameters = parameters
        self._comes_and_goes = settings.traffic and isinstance(self._env, IntersectionEnv)
        self.road = self._env.road
        self.start = self._env.vehicle  # highway-env's ego
        if not settings.traffic:
            self.road.vehicles, self.road.objects = [self.start], []
        speed_up(self.road)
        self._adopt([*self.road.vehicles, *self.road.objects])

    def replace_ego(self, ego: Ego) -> None:
        """Put our ego in the place of highway-env's."""
        self.road.vehicles[self.road.vehicles.index(self.start)] = ego
        self._env.vehicle = ego
        self._ego = ego
        self.update_places()

    def advance(self, steps: int, rate_hz: float) -> None:
        """One step of the world, after `steps` others: cars decide at highway-env's rate and move at ours."""
        if steps % _every(self._env.config["simulation_frequency"], rate_hz) == 0:
            self.road.act()
        self.road.step(1.0 / rate_hz)
        if self._comes_and_goes and (steps + 1) % _every(self._env.config["policy_frequency"], rate_hz) == 0:
            self._renew()
        self.update_places()

    def _renew(self) -> None:
        """Let cars come and go, as highway-env's `step` does."""
        self._env._clear_vehicles()  # highway-env has no public name for them
        arrived = self._env._spawn_vehicle(spawn_probability=self._env.config["spawn_probability"])
        self._adopt([] if arrived is None else [arrived])

    def update_places(self) -> None:
        """Give every object its place on the route."""
        ego_x, ego_y = self._ego.position.tolist()
        for obj in (*self.road.vehicles, *self.road.objects):
            if obj is not self._ego:
                x, y = obj.position.tolist()
                near = hypot(x - ego_x, y - ego_y) <= FAR_M
                obj.place = self._place(x, y) if near else NOWHERE

    def _place(self, x: float, y: float) -> Place:
        """(s, lateral) on the route; nan for what is not near it."""
        s, lateral = self.road.network.place_at(x, y, self._ego.place[0])
        return (s, lateral) if abs(lateral) <= BESIDE_M else NOWHERE

    def _adopt(self, objects: list[RoadObject]) -> None:
        """Give objects their kind, and cars the parameters of their class, which may change in the process."""
        for obj in objects:
            obj.kind = kind_of(obj)
            if type(obj) is self._kind:
                vars(obj).update({**self._parameters, **vars(obj)})


def kind_of(obj: RoadObject) -> str:
    """What an object of highway-env is, as the camera draws it."""
    return "barrier" if isinstance(obj, Obstacle) else "car"


def _every(frequency_hz: float, rate_hz: float) -> int:
    """Number of our steps in a period of highway-env."""
    return max(1, round(rate_hz / frequency_hz))


@contextmanager
def _as_written(kind: type) -> Iterator[Parameters]:
    """A class of cars as its source says, while an environment is made; yields the cars' parameters, final at the end.

    highway-env's intersection sets parameters of its traffic on the class, and so of all traffic in the process. An
    episode must not depend on environments that were made before it, by the user or by this project.
    """
    found, parameters = _parameters(vars(kind)), Parameters()
    for base in reversed(kind.__mro__):
        parameters |= _written(base)
    try:
        for name, value in parameters.items():
            setattr(kind, name, value)
        yield parameters
    finally:
        now = _parameters(vars(kind))
        parameters.update(now)
        for name in now.keys() - found.keys():
            delattr(kind, name)
        for name, value in found.items():
            setattr(kind, name, value)


def _parameters(attributes: Mapping[str, Any]) -> Parameters:
    """The parameters among the attributes of a class of highway-env."""
    return {name: value for name, value in attributes.items() if name.isupper()}


@cache
def _written(kind: type) -> Parameters:
    """A class's own parameters as its source says, if it is highway-env's; another's as they are."""
    spec = find_spec(kind.__module__) if kind.__module__.startswith("highway_env.") else None
    if spec is None or spec.loader is None:
        return _parameters(vars(kind))
    fresh = module_from_spec(spec)
    spec.loader.exec_module(fresh)
    return _parameters(vars(getattr(fresh, kind.__name__)))


def build(scenario: HighwayScenario, seed: int, friction: float | None) -> tuple[Traffic, Route, Ego]:
    """The traffic with its road, the route, and the ego, for the episode of a seed."""
    traffic = Traffic(scenario.highway_env, seed)
    start, network = traffic.start, traffic.road.network
    needed_m = scenario.goal.route_m + BEYOND_GOAL_M + SPARE_M
    lanes = stretches(network, start.lane_index, start.position, _roads(scenario, traffic), needed_m)
    line, ends_m = centre_line(network, lanes)
    graph = traffic.road.network = LaneGraph(network, line, _lanes_for_idm(lanes))
    route = _route(scenario, graph, line.length_m, forks(network, lanes, ends_m, scenario.ego.speed_reference_mps))
    speed_mps = start.speed if scenario.ego.speed_mps is None else scenario.ego.speed_mps
    ego = Ego(traffic.road, np.array(start.position, float), float(start.heading), float(speed_mps), friction)
    ego.target_speed = scenario.ego.speed_reference_mps
    traffic.replace_ego(ego)
    return traffic, route, ego


def _roads(scenario: HighwayScenario, traffic: Traffic) -> list[Road]:
    """The roads to the destination: the one that highway-env has planned, or of the id; else the start's road alone."""
    start, planned = traffic.start, getattr(traffic.start, "route", None)
    if planned:
        return [index[:2] for index in planned]
    if (destination := DESTINATIONS.get(scenario.highway_env.id)) is not None:
        return roads_to(traffic.road.network, start.lane_index, destination)
    return [start.lane_index[:2]]


def _lanes_for_idm(lanes: Sequence[Stretch]) -> list[tuple[str, str, int | None]]:
    """The route as highway-env's cars take it; only where the lane must change is its number given."""
    return [(*one.left[:2], one.left[2] if one.changes_lane else None) for one in lanes]


def _route(scenario: HighwayScenario, graph: LaneGraph, length_m: float, route_forks: tuple[Fork, ...]) -> Route:
    """The route along the graph's reference line, up to the goal or the end of the lanes."""
    goal_m = min(scenario.goal.route_m, length_m)
    (x, y), heading = graph.centre.position_at(goal_m, 0.0), graph.centre.heading_at(goal_m)
    sides = graph.edges_at(x, y, heading)
    if isnan(sides[0]):  # in a junction
        sides = -ROUTE_HALF_M, ROUTE_HALF_M
    return Route(graph.centre, 0.0, goal_m, goal_sides_m=sides, forks=route_forks)
