"""The first-person camera: renders a highway-env road with its core in C."""

from typing import TYPE_CHECKING, Any

from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.weather import Weather

if TYPE_CHECKING:
    from vpf_sim.envs.camera.renderer import Renderer

__all__ = ["Renderer", "Rig", "Weather"]


def __getattr__(name: str) -> Any:
    """Import the renderer, and with it highway-env and OpenCV, on first use."""
    if name == "Renderer":
        from vpf_sim.envs.camera.renderer import Renderer

        return Renderer
    raise AttributeError(f"module 'vpf_sim.envs.camera' has no attribute '{name}'")
