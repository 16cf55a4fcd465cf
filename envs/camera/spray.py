"""Water that moving bodies throw up from a wet road."""

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.things import Snapshot
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.types import Camera


class Spray:
    """Soft puffs behind moving bodies."""

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light, seed: int) -> None:
        pass

    def added(self, drawn: list[Drawn], now: Snapshot, before: Snapshot) -> list[Drawn]:
        """The things in painter's order with the puffs in their places among them."""
        return drawn
