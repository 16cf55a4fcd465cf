"""The driver that is cloned. Its labels say what to do now, also where the network drove until now."""

from math import atan

from vpf_sim import drivers
from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation
from vpf_sim.planning.spacetime.replanning import GAINS

SLOWEST_MPS = 2.0  # below it the steering for a yaw rate stays within bounds


class Teacher(Driver):
    """A driver of the registry.

    A controller that integrates the steering, as that of `expert` does, runs to the stop while another steers. So where
    the driver shows its plan, the steering is that for the yaw rate r on the controller's manifold,

        r = d psi_d / dt - c_r (psi - psi_d),    delta = atan(L r / v),

    to which the integrator converges while the driver has the wheel.
    """

    def __init__(self, name: str) -> None:
        self._driver = drivers.create(name)
        self.privileged = self._driver.privileged
        self.uses_images = drivers.uses_images(self._driver)

    def reset(self, setup: DriverSetup) -> None:
        self._driver.reset(setup)
        self._vehicle = setup.vehicle
        self._controller = Gtsmc(load_gains(GAINS), setup.vehicle, setup.rate_hz)

    def act(self, observation: Observation) -> Command:
        command = drivers.command_of(self._driver, observation)
        plan = drivers.trace_of(self._driver)
        if plan is None or plan.reference.heading_rate_radps is None:
            return command
        off_radps = self._controller.manifold(observation, plan.reference, plan.reference.heading_rate_radps)
        rate_radps = observation.yaw_rate_radps - off_radps
        angle_rad = atan(self._vehicle.wheelbase_m * rate_radps / max(observation.speed_mps, SLOWEST_MPS))
        return Command(command.throttle, max(-1.0, min(1.0, angle_rad / self._vehicle.steering_limit_rad)))
