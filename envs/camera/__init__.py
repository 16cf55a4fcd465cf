"""The first-person camera: numpy and OpenCV only, from a highway-env road."""

from vpf_sim.envs.camera.renderer import Renderer
from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.weather import Weather

__all__ = ["Renderer", "Rig", "Weather"]
