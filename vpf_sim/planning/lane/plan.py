"""What the lane planner hands on with its reference."""

from dataclasses import dataclass

from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.lateral_cost import LanePotential
from vpf_sim.types import PlanDetails


@dataclass(frozen=True, slots=True)
class LanePlan(PlanDetails):
    """One step of the lane planner, in lane coordinates."""

    lane: Lane
    obstacles: LaneObstacles
    potential: LanePotential
    reference_y_m: float  # lateral position of the reference path
