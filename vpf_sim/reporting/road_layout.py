"""The road and static obstacles of a scenario for each seed."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vpf_sim import scenarios
from vpf_sim.envs.centre_line import ReferenceLine
from vpf_sim.envs.network import RoadLines
from vpf_sim.envs.route import Route
from vpf_sim.envs.world import World, build_world
from vpf_sim.reporting.top_view import Rectangle
from vpf_sim.scenarios import DrawnScenario, Scenario
from vpf_sim.scenarios.kinds import SIZES
from vpf_sim.types import Floats

MARGIN_M = 12.0  # of road beyond the start and the goal
EVERY_M = 2.0
ROUTE_POINTS = 120


@dataclass(frozen=True, slots=True)
class StaticObstacle:
    """An obstacle that does not move."""

    corners_m: Floats  # (4, 2) in the world
    centre_m: tuple[float, float]
    s_m: float  # along the carriageway
    route_m: tuple[float, float]  # along the route, from its rear to its front
    offset_m: tuple[float, float]  # right of the route, its left and its right side


@dataclass(frozen=True)
class RoadLayout:
    """The road and static obstacles of a scenario drawn by a seed."""

    scenario: DrawnScenario
    seed: int

    @cached_property
    def world(self) -> World:
        return build_world(self.scenario, self.seed)

    @property
    def centre(self) -> ReferenceLine:
        return self.route.centre

    @property
    def route(self) -> Route:
        return self.world.route

    @cached_property
    def lines(self) -> RoadLines:
        """The road along the route."""
        if not isinstance(self.scenario, Scenario):
            return _near(self.world.road.network.lines(), self.route_line_m)
        road, places = self.scenario.road, self.scenario.road.lane_places
        s = np.arange(self.route.start_s_m - MARGIN_M, self.route.goal_s_m + MARGIN_M + EVERY_M, EVERY_M)
        offsets = (
            np.linspace(-road.half_width_m, road.half_width_m, road.lanes + 1) if places is None else places.borders(s)
        )
        left, *between, right = [self.centre.position(s, offset) for offset in offsets]
        return RoadLines(((left, right),), (left, right), tuple(between))

    @cached_property
    def route_line_m(self) -> Floats:
        """(M, 2) the lane's centre from the start to the goal."""
        s = np.linspace(self.route.start_s_m, self.route.goal_s_m, ROUTE_POINTS)
        return self.centre.position(s, [self.route.offset_at(one) for one in s])

    @property
    def edges_m(self) -> tuple[float, ...]:
        """The carriageway's edges, right of the route; none where they change along the route."""
        if not isinstance(self.scenario, Scenario) or self.scenario.road.widths:
            return ()
        half = self.scenario.road.half_width_m
        return -half - self.route.offset_m, half - self.route.offset_m

    def has_the_road_of(self, other: "RoadLayout") -> bool:
        """Whether another layout has the same road, and the same route."""
        if isinstance(self.scenario, Scenario) and isinstance(other.scenario, Scenario):
            return self.scenario.road == other.scenario.road
        return np.array_equal(self.route_line_m, other.route_line_m)

    @cached_property
    def static_obstacles(self) -> tuple[StaticObstacle, ...]:
        """The obstacles of a scenario file; highway-env's are not among them."""
        if not isinstance(self.scenario, Scenario):
            return ()
        found = enumerate(self.scenario.bodies)
        return tuple(_static_obstacle(self, self.scenario, number) for number, one in found if not one.is_actor)

    @property
    def has_traffic(self) -> bool:
        """Whether any object moves."""
        if isinstance(self.scenario, Scenario):
            return any(one.is_actor for one in self.scenario.bodies)
        return len(self.world.road.vehicles) > 1


def layouts(scenario: str | scenarios.AnyScenario, seeds: list[int]) -> dict[int, RoadLayout]:
    """The layout of a scenario for each seed."""
    undrawn = scenarios.load(scenario)
    return {seed: RoadLayout(undrawn.draw(seed), seed) for seed in seeds}


def _static_obstacle(layout: RoadLayout, scenario: Scenario, number: int) -> StaticObstacle:
    obstacle, route = scenario.bodies[number], layout.route
    size = SIZES[obstacle.kind]
    lateral = scenario.road.lane_offset_m(obstacle.lane, obstacle.s_m) + obstacle.lateral_m
    x, y = layout.centre.position_at(obstacle.s_m, lateral)
    heading = layout.centre.heading_at(obstacle.s_m)
    drawn = Rectangle(x, y, heading, size.length_m, size.width_m, obstacle.kind)
    middle, offset = route.progress(obstacle.s_m), lateral - route.offset_at(obstacle.s_m)
    half_length, half_width = 0.5 * size.length_m, 0.5 * size.width_m
    return StaticObstacle(
        drawn.corners_m,
        (x, y),
        obstacle.s_m,
        (middle - half_length, middle + half_length),
        (offset - half_width, offset + half_width),
    )


def _near(lines: RoadLines, route_m: Floats) -> RoadLines:
    """The parts of the lines that are near a route."""
    low, high = route_m.min(axis=0) - MARGIN_M, route_m.max(axis=0) + MARGIN_M

    def part(line: Floats) -> slice:
        inside = np.flatnonzero(((line > low) & (line < high)).all(axis=1))
        return slice(max(0, inside[0] - 1), inside[-1] + 2) if len(inside) else slice(0)

    def parts(found: tuple[Floats, ...]) -> Iterator[Floats]:
        return (line[part(line)] for line in found if len(line[part(line)]) > 1)

    strips = tuple((left[part(left)], right[part(left)]) for left, right in lines.strips_m if len(left[part(left)]) > 1)
    return RoadLines(strips, tuple(parts(lines.solid_m)), tuple(parts(lines.dashed_m)))
