"""The wet road, a mirror at grazing angles."""

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Image


class WetRoad:
    """Mirrors sky and things on the road."""

    def __init__(
        self, camera: Camera, shapes: list[LaneShape], atmosphere: Atmosphere, light: Light, seed: int
    ) -> None:
        pass

    def draw(self, frame: Image, view: View, drawn: list[Drawn]) -> None:
        """Mirror what is drawn above the horizon and the things that will be drawn, in place."""
