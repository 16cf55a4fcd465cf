"""The road and static obstacles of a scenario for each seed."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vpf_sim import scenarios
from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.envs.route import Route
from vpf_sim.reporting.top_view import Rectangle
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.kinds import SIZES
from vpf_sim.types import Floats

MARGIN_M = 12.0  # of road beyond the start and the goal
EVERY_M = 2.0


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

    scenario: Scenario

    @cached_property
    def centre(self) -> CentreLine:
        return CentreLine(self.scenario.road)

    @cached_property
    def route(self) -> Route:
        return Route(self.centre, self.scenario)

    @cached_property
    def lane_lines_m(self) -> tuple[Floats, ...]:
        """(M, 2) each, lane lines from the left edge to the right, along the route."""
        road = self.scenario.road
        ends = self.scenario.ego.s_m, self.scenario.goal.s_m
        s = np.arange(min(ends) - MARGIN_M, max(ends) + MARGIN_M + EVERY_M, EVERY_M)
        offsets = np.linspace(-road.half_width_m, road.half_width_m, road.lanes + 1)
        return tuple(self.centre.position(s, offset) for offset in offsets)

    @cached_property
    def route_line_m(self) -> Floats:
        """(M, 2) the lane's centre from the start to the goal."""
        s = np.linspace(self.scenario.ego.s_m, self.scenario.goal.s_m, 120)
        return self.centre.position(s, self.route.offset_m)

    @property
    def edges_m(self) -> tuple[float, float]:
        """The carriageway's edges, right of the route."""
        half = self.scenario.road.half_width_m
        return -half - self.route.offset_m, half - self.route.offset_m

    @cached_property
    def static_obstacles(self) -> tuple[StaticObstacle, ...]:
        return tuple(
            self._static_obstacle(number)
            for number, obstacle in enumerate(self.scenario.bodies)
            if not obstacle.is_actor
        )

    @property
    def moving(self) -> int:
        """Number of moving objects."""
        return len(self.scenario.bodies) - len(self.static_obstacles)

    def _static_obstacle(self, number: int) -> StaticObstacle:
        obstacle = self.scenario.bodies[number]
        size = SIZES[obstacle.kind]
        lateral = self.scenario.road.lane_offset_m(obstacle.lane) + obstacle.lateral_m
        x, y = self.centre.position_at(obstacle.s_m, lateral)
        heading = self.centre.heading_at(obstacle.s_m)
        drawn = Rectangle(x, y, heading, size.length_m, size.width_m, obstacle.kind)
        middle, offset = self.route.progress(obstacle.s_m), lateral - self.route.offset_m
        half_length, half_width = 0.5 * size.length_m, 0.5 * size.width_m
        return StaticObstacle(
            drawn.corners_m,
            (x, y),
            obstacle.s_m,
            (middle - half_length, middle + half_length),
            (offset - half_width, offset + half_width),
        )


def layouts(scenario: str, seeds: list[int]) -> dict[int, RoadLayout]:
    """The layout of a scenario for each seed."""
    undrawn = scenarios.load(scenario)
    return {seed: RoadLayout(undrawn.draw(seed)) for seed in seeds}
