"""Plans in space and time ten times a second, and follows the motion in between; `expert` and `vpf` share it."""

from vpf_sim.driver_interface import Observation
from vpf_sim.planning.spacetime import settings
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.planning.spacetime.planner import SpacetimePlanner
from vpf_sim.planning.spacetime.tracking import reference
from vpf_sim.scene import Road, Scene
from vpf_sim.types import Reference, VehicleModel

REPLAN_S = 0.1
GAINS = "motion"  # of the controller that follows
EXACT_S = 1e-6  # rounding of times


class MotionReplanner:
    """The planner with its last motion."""

    def __init__(self, vehicle: VehicleModel) -> None:
        self._vehicle = vehicle
        self._planner = SpacetimePlanner(settings.load(), vehicle)

    def is_due(self, time_s: float) -> bool:
        """Whether a new motion is due."""
        last = self._planner.motion
        return last is None or time_s >= last.time_s + REPLAN_S - EXACT_S

    def plan(self, scene: Scene) -> None:
        """Plan the motion anew."""
        self._planner.plan(scene)

    def follow(
        self, road: Road, observation: Observation, place_m: tuple[float, float]
    ) -> tuple[Reference, MotionPlan]:
        """The reference for the car at (s, d) m, and the motion that it follows."""
        motion = self._planner.motion
        if motion is None:
            raise ValueError("motion: expected a plan before the first reference, got none")
        wanted = reference(motion, road, observation, place_m, self._vehicle)
        return wanted, MotionPlan(motion, road, self._vehicle, observation.pose)
