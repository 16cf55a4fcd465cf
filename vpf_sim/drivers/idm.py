"""The baseline that is given the whole world: highway-env's own driver."""

from vpf_sim.errors import InputError
from vpf_sim.types import Command, Driver, DriverSetup, Observation, Privilege


class IdmDriver(Driver):
    """highway-env's own driver. It is told all that is on the road, and needs no camera."""

    privileged: Privilege = "world"
    uses_images = False

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.controllers.idm import Idm, load_gains

        if setup.world is None:
            raise InputError("driver idm: expected the world in its setup, got none")
        self._controller = Idm(load_gains(), setup, setup.world)

    def act(self, observation: Observation) -> Command:
        return self._controller.command(observation)
