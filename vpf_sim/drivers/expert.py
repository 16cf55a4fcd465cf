"""The driver that is given the whole world: the planner in space and time on the true scene."""

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.errors import InputError
from vpf_sim.types import Plan


class ExpertDriver(Driver):
    """It is given all that is on the road, and needs no camera. It shows which scenarios can be driven at all."""

    privileged: Privilege = "world"
    uses_images = False

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.drivers.motion_follower import MotionFollower
        from vpf_sim.scene.truth import TrueScene

        if setup.world is None:
            raise InputError("driver expert: expected the world in its setup, got none")
        self._truth = TrueScene(setup)
        self._follower = MotionFollower(setup)

    def act(self, observation: Observation) -> Command:
        if self._follower.is_due(observation.time_s):
            self._follower.replan(self._truth.at(observation))
        return self._follower.command(self._truth.road, observation, self._truth.place(observation))

    def trace(self) -> Plan | None:
        """The plan of the last step, for overlays and scores."""
        return self._follower.plan
