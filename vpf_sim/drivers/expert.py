"""The driver that is given the whole world: the planner in space and time on the true scene."""

from typing import TYPE_CHECKING

from vpf_sim.errors import InputError
from vpf_sim.types import Command, Driver, DriverSetup, Observation, Privilege

if TYPE_CHECKING:
    from vpf_sim.planning.spacetime.planner import Motion

REPLAN_S = 0.1
EXACT_S = 1e-6  # rounding of times


class ExpertDriver(Driver):
    """It is given all that is on the road, and needs no camera. It shows which scenarios can be driven at all."""

    privileged: Privilege = "world"
    uses_images = False

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.planning.spacetime import settings
        from vpf_sim.planning.spacetime.planner import SpacetimePlanner
        from vpf_sim.scene.truth import TrueScene

        if setup.world is None:
            raise InputError("driver expert: expected the world in its setup, got none")
        self._vehicle = setup.vehicle
        self._truth = TrueScene(setup)
        self._planner = SpacetimePlanner(settings.load(), setup.vehicle)
        self.motion: Motion | None = None

    def act(self, observation: Observation) -> Command:
        from vpf_sim.controllers import trajectory
        from vpf_sim.planning.spacetime.tracking import target

        if self.motion is None or observation.time_s >= self.motion.time_s + REPLAN_S - EXACT_S:
            self.motion = self._planner.plan(self._truth.at(observation))
        place = self._truth.place(observation)
        return trajectory.command(
            target(self.motion, self._truth.road, observation, place, self._vehicle),
            observation.speed_mps,
            self._vehicle,
        )
