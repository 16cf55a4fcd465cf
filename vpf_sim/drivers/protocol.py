"""How any driver is called: its command, whether it needs frames, and its plan if it shows one."""

from math import isfinite, nan
from typing import Any

import numpy as np

from vpf_sim import process_state
from vpf_sim.driver_interface import Command, Driver, Observation
from vpf_sim.errors import shown
from vpf_sim.timing import timed
from vpf_sim.types import Perception, Plan


@timed("driver")
def command_of(driver: Driver, observation: Observation) -> Command:
    """What a driver does, within the limits; anything but a command of finite numbers is the driver's fault."""
    _protect(observation)
    command = driver.act(observation)
    if not isinstance(command, Command):
        raise TypeError(f"driver: act: expected a vpf_sim.Command, got {shown(command)}{_place(driver)}")
    values = {name: _number(getattr(command, name)) for name in ("throttle", "steering")}
    for name, value in values.items():
        if not isfinite(value):
            got = f"{shown(getattr(command, name))}{_place(driver)}"
            raise ValueError(f"driver: Command: {name}: expected a finite number, got {got}")
    return Command(**{name: min(max(value, -1.0), 1.0) for name, value in values.items()})


def _number(given: Any) -> float:
    """The value of a number, or of an array or tensor of one number; nan for anything else."""
    try:
        return float(given.item() if hasattr(given, "item") else np.asarray(given).item())
    except (TypeError, ValueError, OverflowError, RuntimeError):  # RuntimeError: torch's, for more than one element
        return nan


def _place(driver: Driver) -> str:
    """Where a driver's `act` is written, since the fault shows only after its return."""
    code = getattr(getattr(process_state.unwrapped(driver), "act", None), "__code__", None)
    return "" if code is None else f" ({code.co_filename}, line {code.co_firstlineno})"


def _protect(observation: Observation) -> None:
    """Make the image read-only: others get it after the driver."""
    observation.image.flags.writeable = False


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


def uncertainty_of(driver: Driver) -> float:
    """How unsure a driver is of its last command; nan where it does not say."""
    uncertainty = getattr(driver, "uncertainty", None)
    return nan if uncertainty is None else _number(uncertainty())


def perception_of(driver: Driver, observation: Observation) -> Perception | None:
    """What a driver perceives: by its `perceive`, else by the plan that it makes; None if it shows neither."""
    _protect(observation)
    perceive = getattr(driver, "perceive", None)
    perception = perceive(observation) if perceive is not None else None
    if isinstance(perception, Perception):
        return perception
    command_of(driver, observation)
    plan = trace_of(driver)
    return None if plan is None else plan.perception
