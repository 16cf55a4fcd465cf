"""The baselines that are given the route: waypoint PID, pure pursuit and Stanley; blind to obstacles."""

from collections.abc import Callable

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.errors import InputError
from vpf_sim.types import Floats


class RouteDriver(Driver):
    """A controller that follows the route at the reference speed. It knows no obstacles."""

    privileged: Privilege = "route"
    uses_images = False

    def __init__(self, name: str) -> None:
        self._name = name

    def reset(self, setup: DriverSetup) -> None:
        if setup.route is None:
            raise InputError(f"driver {self._name}: expected a route in its setup, got none")
        self._follow = _FOLLOWERS[self._name](setup, setup.route)

    def act(self, observation: Observation) -> Command:
        return self._follow(observation)


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


class IdmDriver(Driver):
    """highway-env's own driver. It is given all that is on the road, and needs no camera."""

    privileged: Privilege = "world"
    uses_images = False

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.controllers.idm import Idm, load_gains

        if setup.world is None:
            raise InputError("driver idm: expected the world in its setup, got none")
        self._controller = Idm(load_gains(), setup, setup.world)

    def act(self, observation: Observation) -> Command:
        return self._controller.command(observation)


class NeutralDriver(Driver):
    """Touches nothing: the trivial driver."""

    privileged: Privilege = "none"
    uses_images = False

    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        return Command(0.0, 0.0)
