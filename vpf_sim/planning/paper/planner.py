"""The paper's planner: the heading is the direction of the total force at the vehicle, turned into the world."""

from dataclasses import dataclass
from math import inf

from vpf_sim.configuration import settings
from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.planning.paper import obstacle_field, road_field, target_field, total_field
from vpf_sim.planning.paper.lane import Lane, locate
from vpf_sim.planning.paper.obstacle_field import ObstacleFieldConfig
from vpf_sim.planning.paper.reference import HeadingReference, ReferenceConfig
from vpf_sim.planning.paper.road_field import Bend, FoeBend, RoadFieldConfig
from vpf_sim.planning.paper.target_field import TargetFieldConfig
from vpf_sim.planning.paper.total_field import TotalFieldConfig
from vpf_sim.planning.planner_interface import Planned, Planner
from vpf_sim.types import Perception, PlanDetails, Reference


@settings
class PaperPlannerConfig:
    target_field: TargetFieldConfig
    obstacle_field: ObstacleFieldConfig
    road_field: RoadFieldConfig
    total_field: TotalFieldConfig
    reference: ReferenceConfig


@dataclass(frozen=True, slots=True)
class PaperPlan(PlanDetails):
    """One step of the paper's planner."""

    lane: Lane
    bend: Bend


class PaperPlanner(Planner):
    """Follows the direction of the total force."""

    def __init__(self, setup: DriverSetup, config: PaperPlannerConfig) -> None:
        self._setup = setup
        self._config = config
        self._bend = FoeBend(config.road_field, setup.camera, setup.rate_hz)
        self._heading: HeadingReference | None = None

    def step(self, perception: Perception, observation: Observation, limit_mps: float = inf) -> Planned:
        config = self._config
        x, y, yaw = observation.x_m, observation.y_m, observation.yaw_rad
        if self._heading is None:
            self._heading = HeadingReference(config.reference, yaw)
        lane = locate(perception.road)
        target = target_field.force(x, y, yaw, observation.goal_m, lane, config.target_field)
        obstacle = obstacle_field.force(
            perception.features.obstacle_map, perception.features.ttc_s, self._setup.camera, config.obstacle_field
        )
        bend = self._bend.update(perception.expansion.x_px)
        right_m, left_m = road_field.edges(lane, perception.road.lane_width_m, config.road_field)
        road = road_field.force(lane.y_m, right_m, left_m, bend, config.road_field)
        force = total_field.compose(target, obstacle, road, config.total_field)
        world = total_field.to_world(force.total, yaw, config.total_field)
        heading = self._heading.update(world)
        return force, Reference(heading, min(self._setup.speed_reference_mps, limit_mps)), PaperPlan(lane, bend)
