"""Closed-loop harness for vision-based driving: camera frames in, throttle and steering out.

    import vpf_sim

    class MyDriver(vpf_sim.Driver):
        def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
            return vpf_sim.Command(throttle=0.2, steering=0.0)

    episode = vpf_sim.drive("town04", driver=MyDriver, weather="rain", seed=3)
    run = vpf_sim.sweep("random", driver=["vpf", MyDriver], seeds="0:5")
    vpf_sim.report(run)

`import vpf_sim` also registers the environments `vpf_sim/FourLane-v0` and `vpf_sim/FourLanePixels-v0` with gymnasium.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gymnasium.envs.registration import register

if TYPE_CHECKING:
    from vpf_sim.api.drive import Episode, drive
    from vpf_sim.api.report import export, report
    from vpf_sim.api.run import Run
    from vpf_sim.api.sweep import sweep
    from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation
    from vpf_sim.envs.camera.rig import Rig
    from vpf_sim.envs.observation import CameraObservation
    from vpf_sim.errors import InputError
    from vpf_sim.types import Camera

__version__ = "0.3.0.dev0"
__all__ = [
    "Camera",
    "CameraObservation",
    "Command",
    "Driver",
    "DriverSetup",
    "Episode",
    "InputError",
    "Observation",
    "Rig",
    "Run",
    "__version__",
    "drive",
    "export",
    "report",
    "sweep",
]
_MODULES = {
    "Camera": "types",
    "CameraObservation": "envs.observation",
    "Command": "driver_interface",
    "Driver": "driver_interface",
    "DriverSetup": "driver_interface",
    "Episode": "api.drive",
    "InputError": "errors",
    "Observation": "driver_interface",
    "Rig": "envs.camera.rig",
    "Run": "api.run",
    "drive": "api.drive",
    "export": "api.report",
    "report": "api.report",
    "sweep": "api.sweep",
}

register(id="vpf_sim/FourLane-v0", entry_point="vpf_sim.envs.four_lane:FourLane")
register(id="vpf_sim/FourLanePixels-v0", entry_point="vpf_sim.envs.learning:FourLanePixels")


def __getattr__(name: str) -> Any:
    """Import a requested name, and with it numpy, OpenCV or highway-env, on first use."""
    if name not in _MODULES:
        raise AttributeError(f"module 'vpf_sim' has no attribute '{name}'")
    value = getattr(import_module(f"vpf_sim.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
