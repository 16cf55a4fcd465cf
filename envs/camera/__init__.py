"""The first-person camera: numpy and OpenCV only, from a highway-env road."""

from typing import TYPE_CHECKING, Any

from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.weather import Weather

if TYPE_CHECKING:
    from vpf_sim.envs.camera.renderer import Renderer

__all__ = ["Renderer", "Rig", "Weather"]


def __getattr__(name: str) -> Any:
    """Load the renderer, and with it highway-env and OpenCV, only when it is asked for."""
    if name == "Renderer":
        from vpf_sim.envs.camera.renderer import Renderer

        return Renderer
    raise AttributeError(f"module 'vpf_sim.envs.camera' has no attribute '{name}'")
