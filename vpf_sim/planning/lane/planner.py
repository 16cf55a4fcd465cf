"""The lane planner: to the minimum of the lateral cost, along the road's direction."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.planning.lane.frame import NOTHING, Lane, LaneObstacles, locate, place
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig
from vpf_sim.planning.lane.lateral_cost import CostProfile, LateralCost
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.recovery import Recovery
from vpf_sim.planning.lane.reference import LaneReference
from vpf_sim.planning.planner_interface import Planned, Planner
from vpf_sim.planning.visibility import SpeedInSight
from vpf_sim.types import Force, Obstacles, Perception, PlanDetails, Reference


@dataclass(frozen=True, slots=True)
class LanePlan(PlanDetails):
    """One step of the lane planner, in lane coordinates."""

    lane: Lane
    obstacles: LaneObstacles
    cost: CostProfile
    reference_y_m: float  # lateral position of the reference path


class LanePlanner(Planner):
    """Follows the minimum of the lateral cost from frame to frame."""

    def __init__(self, setup: DriverSetup, config: LanePlannerConfig, in_sight: SpeedInSight) -> None:
        self._setup, self._config, self._in_sight = setup, config, in_sight
        kinematics = KinematicLimits(config, setup.vehicle)
        self._empty = ObstacleGeometry(NOTHING, config, setup)
        self._cost = LateralCost(config, setup, kinematics)
        self._reference = LaneReference(config, setup, kinematics)
        self._recovery = Recovery(config.recovery, config, setup) if config.recovery else None
        self._allowed_mps = setup.speed_reference_mps  # by what is seen

    @property
    def is_recovering(self) -> bool:
        """Whether a manoeuvre out of a dead end is driven."""
        return self._recovery is not None and self._recovery.manoeuvre is not None

    def step(self, perception: Perception, observation: Observation, limit_mps: float = inf) -> Planned:
        road, out = perception.road, self._recovery
        lane = locate(road) if out is None else out.lane(road, observation)
        obstacles = place(perception.obstacles, lane, self._config.obstacles.parts)
        geometry = ObstacleGeometry(obstacles, self._config, self._setup) if len(obstacles) else self._empty
        cost = self._cost.update(lane, geometry, observation.speed_mps)
        wanted = self._reference.update(lane, geometry, cost.minimum_m, observation.yaw_rad, observation.speed_mps)
        slowed = self._slowed(wanted, perception, observation.speed_mps)
        turned = self._recovered(lane, perception.obstacles, observation, wanted)
        reference = slowed if turned is None else turned
        reference = replace(reference, speed_mps=min(reference.speed_mps, limit_mps))
        plan = LanePlan(lane, obstacles, cost, self._reference.y_m)
        return _force(cost, lane.y_m), reference, plan

    def _slowed(self, reference: Reference, perception: Perception, speed_mps: float) -> Reference:
        """The reference, slowed by the clear distance and where the road is not seen.

        This limit falls as the car may brake from its speed, and rises gently.
        """
        braking = self._config.braking
        allowed = self._in_sight.limit(perception, speed_mps * (1.0 / self._setup.rate_hz))
        least = min(self._allowed_mps, speed_mps) - braking.emergency_mps2 / self._setup.rate_hz
        most = self._allowed_mps + braking.rise_mps2 / self._setup.rate_hz
        self._allowed_mps = allowed = min(max(allowed, least), most, self._setup.speed_reference_mps)
        return replace(reference, speed_mps=allowed) if allowed < reference.speed_mps else reference

    def _recovered(
        self, lane: Lane, obstacles: Obstacles, observation: Observation, wanted: Reference
    ) -> Reference | None:
        """The reference of a manoeuvre out of a dead end, or None; afterwards the planner restarts from there.

        A car that stands only because the road is not seen is in no dead end.
        """
        if self._recovery is None:
            return None
        was_driven = self.is_recovering
        turned = self._recovery.update(lane, obstacles, observation, wanted)
        if was_driven or turned is not None:
            self._in_sight.restart()
            self._cost.keep(lane.y_m)
            self._reference.restart(observation.speed_mps)
        return turned


def _force(cost: CostProfile, y_m: float) -> Force:
    """-grad U at the vehicle, for display: across the road, with the target's pull of 1 along it."""
    forces = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    forces[:, 1] = -cost.slope(y_m)
    target, road, obstacle = forces
    return Force(target, obstacle, road, target + obstacle + road)
