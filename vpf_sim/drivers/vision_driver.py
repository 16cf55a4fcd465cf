"""The driver under test: perception, planner and sliding mode controller of a variant."""

from dataclasses import replace

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.errors import InputError
from vpf_sim.timing import call
from vpf_sim.types import Perception, Plan


class VisionDriver(Driver):
    """Drives by camera with a variant, given by name or file."""

    privileged: Privilege = "none"

    def __init__(self, variant: str) -> None:
        from vpf_sim.controllers.gtsmc import load_gains
        from vpf_sim.planning import variant as variants

        self.variant = variants.load(variant)
        try:
            self.gains = load_gains(self.variant.gains)
        except InputError as error:
            raise InputError(f"{variant}: gains: {error}") from None
        self._plan: Plan | None = None

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.controllers.gtsmc import Gtsmc
        from vpf_sim.drivers.perceiver import OwnMotion, Perceiver
        from vpf_sim.planning.planner import create_planner

        self._perceiver = Perceiver(setup, self.variant)
        self._planner = create_planner(setup, self.variant)
        self._controller = Gtsmc(self.gains, setup.vehicle, setup.rate_hz)
        self._own_motion = OwnMotion(setup, self.variant)
        self._plan = None

    def act(self, observation: Observation) -> Command:
        observation = self._own_motion.update(observation)
        perception = self._perceived(observation)
        plan = call("plan", self._plan_step, perception, observation)
        command = call("control", self._controller.command, observation, plan.reference)
        self._plan = replace(plan, reaching=self._controller.reaching.holds)
        return command

    def perceive(self, observation: Observation) -> Perception:
        """What `act` would perceive, without planning or steering; one of the two is called each step."""
        return self._perceived(self._own_motion.update(observation))

    def _perceived(self, observation: Observation) -> Perception:
        perception = self._perceiver.perceive(observation)
        return self._planner.observe(perception, observation, self._perceiver.evidence)

    def _plan_step(self, perception: Perception, observation: Observation) -> Plan:
        """Fields, heading and speed reference; without new frames, a stop."""
        return Plan(perception, *self._planner.step(perception, observation, self._perceiver.limit_mps(observation)))

    @property
    def needs_next_frame(self) -> bool:
        """Whether it processes the next frame."""
        return self._perceiver.needs_next_frame

    def trace(self) -> Plan | None:
        """The plan of the last step, for overlays and scores."""
        return self._plan
