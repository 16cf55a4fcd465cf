"""The drivers that are known by name, variants of the vision driver, and users' own."""

from collections.abc import Callable
from dataclasses import dataclass
from inspect import getdoc
from pathlib import Path

from vpf_sim import process_state
from vpf_sim.driver_interface import Driver, Privilege
from vpf_sim.drivers import own
from vpf_sim.drivers.baselines import IdmDriver, NeutralDriver, RouteDriver
from vpf_sim.drivers.expert import ExpertDriver
from vpf_sim.drivers.vision_driver import VisionDriver
from vpf_sim.errors import InputError, unknown_name

VARIANT_PREFIX = "vpf@"  # before the name or file of a variant
MODEL_PREFIX = "onnx:"  # before the file of a learned policy
_INSTALLED = Path(__file__).parent / "learned"
KEYBOARD = "keyboard"  # a person, who drives one episode at a time and none twice
LEARNED = {  # the policies that are installed
    "learned-bc": _INSTALLED / "learned_bc.onnx",
    "learned-ppo": _INSTALLED / "learned_ppo.onnx",
}


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


def _lane_lines() -> Driver:
    from vpf_sim.drivers.lane_lines import LaneLinesDriver  # imports OpenCV, which listings do not need

    return LaneLinesDriver()


def _dominant_plane() -> Driver:
    from vpf_sim.drivers.dominant_plane import DominantPlaneDriver

    return DominantPlaneDriver()


def _learned(model: str | Path) -> Driver:
    from vpf_sim.drivers.learned.driver import OnnxDriver  # imports OpenCV, too

    return OnnxDriver(model)


def _keyboard() -> Driver:
    from vpf_sim.drivers.keyboard import KeyboardDriver

    return KeyboardDriver()


_REGISTRY: dict[str, _Entry] = {
    "vpf": _Entry(
        lambda: VisionDriver("robust"),
        "none",
        "a scene of road and tracks by camera, planned in space and time, sliding mode (variant robust)",
    ),
    "vpf-paper": _Entry(
        lambda: VisionDriver("paper"), "none", "the paper's law, repaired, with the settings that reproduce its table"
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
    "expert": _Entry(
        ExpertDriver, "world", "the least cost of candidate motions in a field over space and time; gets all objects"
    ),
    "lane-lines": _Entry(_lane_lines, "none", "lane lines from above, Stanley's law, a brake by time to contact"),
    "dominant-plane": _Entry(
        _dominant_plane,
        "none",
        "ground by the flow's dominant plane, visual potential, goal direction; blind to road edges",
    ),
    "learned-bc": _Entry(
        lambda: _learned(LEARNED["learned-bc"]), "none", "a small network that was cloned from expert"
    ),
    "learned-ppo": _Entry(
        lambda: _learned(LEARNED["learned-ppo"]),
        "none",
        "a small network that learned by reward to keep its lane and to pass parked cars",
    ),
    KEYBOARD: _Entry(_keyboard, "none", "a person at the keys or a gamepad; needs a display"),
    "neutral": _Entry(NeutralDriver, "none", "no throttle and no steering"),
}


def names() -> list[str]:
    """The registered drivers, ours first."""
    return list(_REGISTRY)


def describe() -> list[Description]:
    """What each registered driver is and what it gets beyond its camera."""
    return [description(name) for name in _REGISTRY]


def description(name: str) -> Description:
    """What a driver of that name is: one of the registry, a variant, a learned policy, or a user's own."""
    if name in _REGISTRY:
        return Description(name, _REGISTRY[name].privileged, _REGISTRY[name].summary)
    driver = create(name)
    return Description(name, driver.privileged, _summary(name, driver))


def has_name(driver: str) -> bool:
    """Whether a name leads to a driver in any process: not of instances, nor of classes of a notebook or script."""
    is_class = ":" in driver and own.is_importable(driver)
    return driver in _REGISTRY or driver.startswith((VARIANT_PREFIX, MODEL_PREFIX)) or is_class


def model_of(driver: str) -> Path | None:
    """The ONNX file of a learned driver; None of another."""
    if driver.startswith(MODEL_PREFIX):
        return Path(driver.removeprefix(MODEL_PREFIX))
    return LEARNED.get(driver)


def create(driver: own.DriverLike) -> Driver:
    """A new driver: a registered name, "vpf@VARIANT" (its name or file), "onnx:FILE", or a user's own.

    A user's own is "package.module:Class", a class that is made without arguments, or an instance.
    """
    if not isinstance(driver, str):
        return own.make(driver, own.name_of(driver))
    if driver.startswith(VARIANT_PREFIX):
        return VisionDriver(driver.removeprefix(VARIANT_PREFIX))
    if driver.startswith(MODEL_PREFIX):
        return _learned(driver.removeprefix(MODEL_PREFIX))
    if ":" in driver or own.is_kept(driver):
        return own.load(driver)
    if driver not in _REGISTRY:
        remedy = own.remedy(driver)
        raise InputError(f"driver '{driver}': {remedy}") if remedy else unknown_name("driver", driver, _REGISTRY)
    return _REGISTRY[driver].make()


def _summary(name: str, driver: Driver) -> str:
    """A variant's or policy's summary, or the first line of the docstring of a user's class."""
    if name.startswith(VARIANT_PREFIX):
        return f"the vision driver, variant {name.removeprefix(VARIANT_PREFIX)}"
    if name.startswith(MODEL_PREFIX):
        from vpf_sim.drivers.learned import manifest

        return manifest.load(Path(name.removeprefix(MODEL_PREFIX))).summary or "a learned policy"
    return (getdoc(type(process_state.unwrapped(driver))) or "").partition("\n")[0]
