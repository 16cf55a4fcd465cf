"""The drivers that are known by name, variants of the vision driver, and users' own by "package.module:Class"."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import cast, get_args

from vpf_sim import process_state
from vpf_sim.drivers.idm import IdmDriver
from vpf_sim.drivers.neutral import NeutralDriver
from vpf_sim.drivers.route_followers import RouteDriver
from vpf_sim.drivers.vision_driver import VisionDriver
from vpf_sim.errors import InputError, unknown_name
from vpf_sim.types import Driver, Privilege

VARIANT_PREFIX = "vpf@"  # before the name or file of a variant


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
    "vpf": _Entry(
        lambda: VisionDriver("robust"),
        "none",
        "tracked obstacles and road, lateral cost, sliding mode (variant robust)",
    ),
    "vpf-paper": _Entry(
        lambda: VisionDriver("paper"), "none", "the paper's method with the fewest repairs that make it run"
    ),
    "vpf-literal": _Entry(
        lambda: VisionDriver("literal"), "none", "the paper's method as printed: a documented negative"
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
    "idm": _Entry(IdmDriver, "world", "highway-env's own driver: IDM along the lane, MOBIL across; gets all objects"),
    "neutral": _Entry(NeutralDriver, "none", "no throttle and no steering"),
}


def names() -> list[str]:
    """The registered drivers, ours first."""
    return list(_REGISTRY)


def describe() -> list[Description]:
    """What each registered driver is and what it gets beyond its camera."""
    return [description(name) for name in _REGISTRY]


def description(name: str) -> Description:
    """What a driver of that name is: one of the registry, or the vision driver in a variant."""
    if name.startswith(VARIANT_PREFIX):
        from vpf_sim.planning import variant

        own, driver = name.removeprefix(VARIANT_PREFIX), create(name)
        return Description(name, driver.privileged, variant.summary(own) or f"the vision driver, variant {own}")
    if name not in _REGISTRY:
        raise unknown_name("driver", name, _REGISTRY)
    return Description(name, _REGISTRY[name].privileged, _REGISTRY[name].summary)


def create(name: str) -> Driver:
    """A new driver: a registered name, "vpf@VARIANT" (its name or file), or a user's own "package.module:Class"."""
    if name.startswith(VARIANT_PREFIX):
        return VisionDriver(name.removeprefix(VARIANT_PREFIX))
    if ":" in name:
        return _load(name)
    if name not in _REGISTRY:
        raise unknown_name("driver", name, _REGISTRY)
    return _REGISTRY[name].make()


def _load(path: str) -> Driver:
    """An instance of the class at "package.module:Class", checked against the driver's protocol."""
    module_name, _, class_name = path.partition(":")
    try:
        with process_state.preserved():
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
        with process_state.preserved():
            driver = cast(Driver, process_state.Isolated(found()))
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
