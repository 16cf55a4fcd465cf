"""The driver that is given the whole world: the planner in space and time on the true scene."""

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.errors import InputError
from vpf_sim.types import NO_FORCE, Plan


class ExpertDriver(Driver):
    """It is given all that is on the road, and needs no camera. It shows which scenarios can be driven at all."""

    privileged: Privilege = "world"
    uses_images = False

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
        from vpf_sim.planning.spacetime.replanning import GAINS, MotionReplanner
        from vpf_sim.scene.truth import TrueScene

        if setup.world is None:
            raise InputError("driver expert: expected the world in its setup, got none")
        self._truth = TrueScene(setup)
        self._motion = MotionReplanner(setup.vehicle)
        self._controller = Gtsmc(load_gains(GAINS), setup.vehicle, setup.rate_hz)
        self._plan: Plan | None = None

    def act(self, observation: Observation) -> Command:
        if self._motion.is_due(observation.time_s):
            self._motion.plan(self._truth.at(observation))
        wanted, extra = self._motion.follow(self._truth.road, observation, self._truth.place(observation))
        command = self._controller.command(observation, wanted)
        self._plan = Plan(None, NO_FORCE, wanted, extra, self._controller.reaching.holds)
        return command

    def trace(self) -> Plan | None:
        """The plan of the last step, for overlays and scores."""
        return self._plan
