"""Plans in space and time ten times a second, and follows the motion; `expert` and `vpf-scene` share it."""

import numpy as np

from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.planning.spacetime import settings
from vpf_sim.planning.spacetime.motion import Motion, MotionPlan
from vpf_sim.planning.spacetime.planner import SpacetimePlanner
from vpf_sim.planning.spacetime.tracking import reference
from vpf_sim.scene import Road, Scene
from vpf_sim.types import Force, Perception, Plan

REPLAN_S = 0.1
GAINS = "motion"
EXACT_S = 1e-6  # rounding of times
NO_FORCE = Force(*np.zeros((4, 2)))


class MotionFollower:
    """The planner with its last motion, and the gradient-tracking sliding mode controller."""

    def __init__(self, setup: DriverSetup) -> None:
        self._vehicle = setup.vehicle
        self._planner = SpacetimePlanner(settings.load(), setup.vehicle)
        self._controller = Gtsmc(load_gains(GAINS), setup.vehicle, setup.rate_hz)
        self.motion: Motion | None = None
        self.plan: Plan | None = None  # of the last step

    def is_due(self, time_s: float) -> bool:
        """Whether a new motion is due."""
        return self.motion is None or time_s >= self.motion.time_s + REPLAN_S - EXACT_S

    def replan(self, scene: Scene) -> None:
        """Plan the motion anew."""
        self.motion = self._planner.plan(scene)

    def command(
        self, road: Road, observation: Observation, place_m: tuple[float, float], perception: Perception | None = None
    ) -> Command:
        """The command for the car at (s, d) m."""
        if self.motion is None:
            raise ValueError("motion: expected a plan before the first command, got none")
        wanted = reference(self.motion, road, observation, place_m, self._vehicle)
        extra = MotionPlan(self.motion, road, observation.pose)
        command = self._controller.command(observation, wanted)
        self.plan = Plan(perception, NO_FORCE, wanted, extra, self._controller.reaching.holds)
        return command
