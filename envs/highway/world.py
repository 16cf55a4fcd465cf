"""Builds the world of a highway-env scenario: the road, the route through it, and the ego at its start."""

from collections.abc import Sequence
from math import isnan

import numpy as np

from vpf_sim.envs.ego import Ego
from vpf_sim.envs.highway.lane_graph import ROUTE_HALF_M, LaneGraph
from vpf_sim.envs.highway.lanes import Road, Stretch, roads_to, stretches
from vpf_sim.envs.highway.path import centre_line
from vpf_sim.envs.highway.traffic import Traffic
from vpf_sim.envs.highway.turns import forks
from vpf_sim.envs.route import BEYOND_GOAL_M, Fork, Route
from vpf_sim.scenarios import HighwayScenario

DESTINATIONS = {"exit-v0": "exit", "exit-v1": "exit"}  # of ids that have one which highway-env does not plan
SPARE_M = 20.0  # lanes beyond the last waypoint


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


def _route(scenario: HighwayScenario, graph: LaneGraph, length_m: float, ways: tuple[Fork, ...]) -> Route:
    """The route along the graph's reference line, up to the goal or the end of the lanes."""
    goal_m = min(scenario.goal.route_m, length_m)
    (x, y), heading = graph.centre.position_at(goal_m, 0.0), graph.centre.heading_at(goal_m)
    sides = graph.edges_at(x, y, heading)
    if isnan(sides[0]):  # in a junction
        sides = -ROUTE_HALF_M, ROUTE_HALF_M
    return Route(graph.centre, 0.0, goal_m, goal_sides_m=sides, forks=ways)
