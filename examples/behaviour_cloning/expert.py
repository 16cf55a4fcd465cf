"""The expert that is cloned: drivers of the registry that know the route or the world."""

from vpf_sim import drivers
from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege


class Expert(Driver):
    """`idm` beside obstacles. On an empty road its throttle, and the steering of `pure-pursuit`, which is calmer."""

    privileged: Privilege = "world"
    uses_images = False

    def __init__(self, has_obstacles: bool) -> None:
        self._world = drivers.create("idm")
        self._route = None if has_obstacles else drivers.create("pure-pursuit")

    def reset(self, setup: DriverSetup) -> None:
        self._world.reset(setup)
        if self._route is not None:
            self._route.reset(setup)

    def act(self, observation: Observation) -> Command:
        command = self._world.act(observation)
        if self._route is None:
            return command
        return Command(command.throttle, self._route.act(observation).steering)
