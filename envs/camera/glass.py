"""Water on the windshield."""

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.things import Snapshot
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.types import Camera, Image


class Glass:
    """Film, droplets and wipers."""

    def __init__(self, camera: Camera, weather: Weather, atmosphere: Atmosphere, light: Light, seed: int) -> None:
        pass

    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Put the water of this moment before the picture, in place."""
