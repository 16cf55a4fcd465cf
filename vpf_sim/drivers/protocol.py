"""How any driver is asked: its command, whether it needs frames, and its plan if it shows one."""

import numpy as np

from vpf_sim.timing import timed
from vpf_sim.types import Command, Driver, Observation, Perception, Plan


@timed("driver")
def command_of(driver: Driver, observation: Observation) -> Command:
    """What a driver does, within the limits; anything but a command of finite numbers is the driver's fault."""
    command = driver.act(observation)
    if not isinstance(command, Command):
        raise TypeError(f"driver: act: expected a vpf_sim.types.Command, got {command!r}")
    values = np.array([command.throttle, command.steering], dtype=float)
    if not np.isfinite(values).all():
        raise ValueError(f"driver: expected finite throttle and steering, got {command}")
    throttle, steering = values.tolist()
    return Command(min(max(throttle, -1.0), 1.0), min(max(steering, -1.0), 1.0))


def uses_images(driver: Driver) -> bool:
    """Whether frames are drawn for a driver: for all but those that declare `uses_images = False`."""
    return bool(getattr(driver, "uses_images", True))


def needs_next_frame(driver: Driver) -> bool:
    """Whether a driver that acted uses the next frame."""
    return uses_images(driver) and bool(getattr(driver, "needs_next_frame", True))


def trace_of(driver: Driver) -> Plan | None:
    """The plan of a driver that shows one."""
    trace = getattr(driver, "trace", None)
    plan = trace() if trace is not None else None
    return plan if isinstance(plan, Plan) else None


def perception_of(driver: Driver, observation: Observation) -> Perception | None:
    """What a driver perceives: by its `perceive`, else by the plan that it makes; None if it shows neither."""
    perceive = getattr(driver, "perceive", None)
    perception = perceive(observation) if perceive is not None else None
    if isinstance(perception, Perception):
        return perception
    command_of(driver, observation)
    plan = trace_of(driver)
    return None if plan is None else plan.perception
