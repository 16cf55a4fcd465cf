"""The trivial baseline: no throttle and no steering."""

from vpf_sim.types import Command, Driver, DriverSetup, Observation, Privilege


class NeutralDriver(Driver):
    """Touches nothing: the trivial driver."""

    privileged: Privilege = "none"
    uses_images = False

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        from vpf_sim.controllers.neutral import Neutral

        self._controller = Neutral()

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        return self._controller.command()
