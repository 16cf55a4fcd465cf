"""What the harness uses of an environment: the ego, its surroundings, and gymnasium's reset and step."""

from typing import Any, Protocol

from numpy.typing import NDArray

from vpf_sim.envs.camera import Renderer
from vpf_sim.envs.network import OnRoad, PopulatedRoad
from vpf_sim.types import Camera, Floats, VehicleModel

Info = dict[str, Any]  # gymnasium's; `vpf_sim.envs.four_lane.FourLane` lists its keys
Observed = dict[str, NDArray[Any]]


class Surroundings(Protocol):
    """The true state of the ego and of what is near it."""

    @property
    def ego(self) -> OnRoad:
        """The car that is driven."""
        ...

    @property
    def road(self) -> PopulatedRoad:
        """The road with all that is on it."""
        ...

    @property
    def nearest(self) -> tuple[float, OnRoad | None]:
        """m from the ego to the nearest object, and that object; inf and None without objects."""
        ...


class FilmedSurroundings(Surroundings, Protocol):
    """The same, with the camera that films them."""

    rate_hz: float
    camera: Camera

    @property
    def renderer(self) -> Renderer | None:
        """The camera's ground truth; None where no frames are drawn."""
        ...


class Environment(FilmedSurroundings, Protocol):
    """An environment in which a driver drives an episode."""

    vehicle_model: VehicleModel
    speed_reference_mps: float
    goal_m: tuple[float, float]
    route: Floats

    def reset(self, *, seed: int) -> tuple[Observed, Info]:
        """Begin the episode of a seed."""
        ...

    def step(self, action: NDArray[Any], *, with_frame: bool = True) -> tuple[Observed, float, bool, bool, Info]:
        """Observation, reward, terminated, truncated and info after a command; the frame only where it is used."""
        ...
