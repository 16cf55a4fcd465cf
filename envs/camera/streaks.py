"""Falling rain in the picture."""

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.things import Snapshot
from vpf_sim.types import Camera, Image


class Streaks:
    """Streaks of falling drops."""

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light, gain: float, seed: int) -> None:
        pass

    def draw(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw the drops of this frame, in place; the camera's velocity is that between the two snapshots."""
