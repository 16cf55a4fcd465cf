"""What is under test: planner and controller together, or a baseline; and the registry that knows them by name.

Naming the drivers loads none of them: planners and controllers are imported when a driver is created.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING, cast, get_args

import numpy as np

from vpf_sim.errors import InputError, unknown_name
from vpf_sim.types import Command, Driver, DriverSetup, Floats, Observation, Plan, Privilege

if TYPE_CHECKING:
    from vpf_sim.controllers.gtsmc import Gains
    from vpf_sim.planning.variant import Variant


class FieldDriver:
    """The Visual Potential Field planner in a variant by name or file, with the sliding mode controller it names."""

    privileged: Privilege = "none"

    def __init__(self, variant: str) -> None:
        from vpf_sim.controllers.gtsmc import load_gains
        from vpf_sim.planning import variant as variants

        self._variant = variants.load(variant)
        self._gains = load_gains(self._variant.gains)
        self._plan: Plan | None = None

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.controllers.gtsmc import Gtsmc
        from vpf_sim.perception.odometry import Odometry
        from vpf_sim.perception.plausible import Plausibility
        from vpf_sim.planning.planner import Planner

        self._planner = Planner(setup, self._variant)
        self._controller = Gtsmc(self._gains, setup.vehicle, setup.rate_hz)
        self._odometry = Odometry(self._variant.odometry, setup.vehicle) if self._variant.odometry else None
        self._plausibility = Plausibility(setup.vehicle)
        self._plan = None

    def act(self, observation: Observation) -> Command:
        observation = self._plausibility.update(observation)
        if self._odometry is not None:
            observation = self._odometry.update(observation)
        plan = self._planner.step(observation)
        command = self._controller.command(observation, plan.reference)
        self._plan = replace(plan, extra={**plan.extra, "reaching": self._controller.reaching})
        return command

    @property
    def looks(self) -> bool:
        """Whether it looks at the next frame."""
        return self._planner.looks

    def trace(self) -> Plan | None:
        """The plan of the last step, for overlays and scores."""
        return self._plan

    @property
    def variant(self) -> "Variant":
        """The configuration of its planner."""
        return self._variant

    @property
    def gains(self) -> "Gains":
        """Those of its controller."""
        return self._gains


class RouteDriver:
    """A controller that follows the route at the reference speed. It knows no obstacles."""

    privileged: Privilege = "route"
    sees = False

    def __init__(self, name: str) -> None:
        self._name = name

    def reset(self, setup: DriverSetup) -> None:
        if setup.route is None:
            raise InputError(f"driver {self._name}: expected a route in its setup, got none")
        self._follow = _FOLLOWERS[self._name](setup, setup.route)

    def act(self, observation: Observation) -> Command:
        return self._follow(observation)

    def trace(self) -> Plan | None:
        """A baseline makes no plan."""
        return None


class IdmDriver:
    """highway-env's own driver. It is told all that is on the road, and needs no camera."""

    privileged: Privilege = "world"
    sees = False

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.controllers.idm import Idm, load_gains

        if setup.world is None:
            raise InputError("driver idm: expected the world in its setup, got none")
        self._controller = Idm(load_gains(), setup, setup.world)

    def act(self, observation: Observation) -> Command:
        return self._controller.command(observation)

    def trace(self) -> Plan | None:
        """No plan of ours."""
        return None


class NeutralDriver:
    """Touches nothing: the trivial driver."""

    privileged: Privilege = "none"
    sees = False

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        from vpf_sim.controllers.neutral import Neutral

        self._controller = Neutral()

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        return self._controller.command()

    def trace(self) -> Plan | None:
        """No plan either."""
        return None


def _pid(setup: DriverSetup, route: Floats) -> Callable[[Observation], Command]:
    from vpf_sim.controllers.pid import WaypointPid, load_gains

    return WaypointPid(load_gains(), route, setup.speed_reference_mps, setup.rate_hz).command


def _pure_pursuit(setup: DriverSetup, route: Floats) -> Callable[[Observation], Command]:
    from vpf_sim.controllers.pure_pursuit import PurePursuit, load_gains

    return _with_speed(PurePursuit(load_gains(), route, setup.vehicle).steer, setup)


def _stanley(setup: DriverSetup, route: Floats) -> Callable[[Observation], Command]:
    from vpf_sim.controllers.stanley import Stanley, load_gains

    return _with_speed(Stanley(load_gains(), route, setup.vehicle).steer, setup)


def _with_speed(steer: Callable[[Observation], float], setup: DriverSetup) -> Callable[[Observation], Command]:
    """A law that steers, with the speed held as the PID holds it."""
    from vpf_sim.controllers.pid import SpeedPid, load_gains

    speed = SpeedPid(load_gains(), setup.speed_reference_mps, setup.rate_hz)
    return lambda observation: Command(speed.throttle(observation.speed_mps), steer(observation))


_FOLLOWERS = {"pid": _pid, "pure-pursuit": _pure_pursuit, "stanley": _stanley}


FIELD = "vpf@"  # before the name or file of a variant


@dataclass(frozen=True, slots=True)
class Description:
    """A row of the drivers' table."""

    name: str
    privileged: Privilege
    summary: str


@dataclass(frozen=True, slots=True)
class _Entry:
    make: Callable[[], Driver]
    privileged: Privilege
    summary: str


_REGISTRY: dict[str, _Entry] = {
    "vpf": _Entry(lambda: FieldDriver("robust"), "none", "the potential field as we would drive it (variant robust)"),
    "vpf-paper": _Entry(
        lambda: FieldDriver("paper"), "none", "the paper's field with the fewest repairs that make it run"
    ),
    "vpf-literal": _Entry(
        lambda: FieldDriver("literal"), "none", "the paper's field as printed: a documented negative"
    ),
    "pid": _Entry(
        lambda: RouteDriver("pid"), "route", "CARLA's waypoint PID, the paper's baseline; blind to obstacles"
    ),
    "pure-pursuit": _Entry(
        lambda: RouteDriver("pure-pursuit"), "route", "steers on an arc to a point ahead (Coulter); blind to obstacles"
    ),
    "stanley": _Entry(
        lambda: RouteDriver("stanley"), "route", "steers by heading and cross-track error; blind to obstacles"
    ),
    "idm": _Entry(IdmDriver, "world", "highway-env's own driver: IDM along the lane, MOBIL across; told all bodies"),
    "neutral": _Entry(NeutralDriver, "none", "touches neither throttle nor steering"),
}


def names() -> list[str]:
    """The registered drivers, ours first."""
    return list(_REGISTRY)


def describe() -> list[Description]:
    """What each registered driver is and what it is told beyond its camera."""
    return [description(name) for name in _REGISTRY]


def description(name: str) -> Description:
    """What a driver of that name is: one of the registry, or the field in a variant of its own."""
    if name.startswith(FIELD):
        from vpf_sim.planning import variant

        own, driver = name.removeprefix(FIELD), create(name)
        return Description(name, driver.privileged, variant.ablation().get(own, f"the potential field, variant {own}"))
    if name not in _REGISTRY:
        raise unknown_name("driver", name, _REGISTRY)
    return Description(name, _REGISTRY[name].privileged, _REGISTRY[name].summary)


def create(name: str) -> Driver:
    """A new driver: a registered name, "vpf@VARIANT" (its name or file), or a user's own "package.module:Class"."""
    if name.startswith(FIELD):
        return FieldDriver(name.removeprefix(FIELD))
    if ":" in name:
        return _load(name)
    if name not in _REGISTRY:
        raise unknown_name("driver", name, _REGISTRY)
    return _REGISTRY[name].make()


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


def sees(driver: Driver) -> bool:
    """Whether a driver looks at the frames: all do but those that say `sees = False`."""
    return bool(getattr(driver, "sees", True))


def looks(driver: Driver) -> bool:
    """Whether a driver that acted looks at the next frame: one that sees does, but where it says `looks = False`."""
    return sees(driver) and bool(getattr(driver, "looks", True))


def trace_of(driver: Driver) -> Plan | None:
    """The plan of a driver that shows one."""
    trace = getattr(driver, "trace", None)
    plan = trace() if trace is not None else None
    return plan if isinstance(plan, Plan) else None


def _load(path: str) -> Driver:
    """An instance of the class at "package.module:Class", checked against the driver's protocol."""
    module_name, _, class_name = path.partition(":")
    try:
        module = import_module(module_name)
    except (ImportError, ValueError) as error:
        raise InputError(f"driver '{path}': cannot import '{module_name}': {error}") from error
    except Exception as error:
        raise InputError(f"driver '{path}': importing '{module_name}' raised {_told(error)}") from error
    found = getattr(module, class_name, None)
    if not isinstance(found, type):
        raise InputError(f"driver '{path}': module '{module_name}' has no class '{class_name}'")
    missing = [part for part in ("privileged", "reset", "act") if not hasattr(found, part)]
    if missing:
        raise InputError(f"driver '{path}': expected privileged, reset and act; missing: {', '.join(missing)}")
    try:
        driver = cast(Driver, found())
    except TypeError as error:
        raise InputError(f"driver '{path}': expected a class that is made without arguments: {error}") from error
    except Exception as error:
        raise InputError(f"driver '{path}': making it raised {_told(error)}") from error
    if driver.privileged not in get_args(Privilege):
        raise InputError(f"driver '{path}': privileged: expected none, route or world, got {driver.privileged!r}")
    return driver


def _told(error: Exception) -> str:
    """An exception of a user's own code in one line; the exception itself is chained."""
    return " ".join(f"{type(error).__name__}: {error}".split())
