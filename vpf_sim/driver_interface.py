"""The interface of a driver: what it is given before an episode and at each step, and what it returns."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isnan, nan
from typing import Any, Literal, Protocol

import numpy as np

from vpf_sim.types import Camera, Floats, Image, Perception, Plan, VehicleModel

Privilege = Literal["none", "route", "world"]
Turn = Literal["lane", "left", "straight", "right"]  # what to do next: keep the lane, or which road to take at a fork


class World(Protocol):
    """highway-env's road with all that is on it, `highway_env.road.road.Road`; its parts are highway-env's."""

    network: Any

    @property
    def vehicles(self) -> Sequence[Any]:
        """Cars and others that move by themselves, the ego among them."""
        ...

    @property
    def objects(self) -> Sequence[Any]:
        """What does not move by itself."""
        ...


@dataclass(frozen=True, slots=True)
class DriverSetup:
    """What a driver is given before an episode: `route` and `world` are None unless it declares the privilege.

    ValueError where the rate, the speed, the goal or the route is one that no drive has.
    """

    camera: Camera
    vehicle: VehicleModel
    rate_hz: float
    speed_reference_mps: float
    goal_m: tuple[float, float]
    seed: int
    route: Floats | None = None  #: (M, 2) m, along the lane's centre from the start to beyond the goal, 1 m apart
    world: World | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.rate_hz < inf:
            raise ValueError(f"rate_hz: expected a finite number > 0, got {self.rate_hz}")
        if not 0.0 <= self.speed_reference_mps < inf:
            raise ValueError(f"speed_reference_mps: expected a finite number >= 0, got {self.speed_reference_mps}")
        if not np.isfinite(self.goal_m).all():
            raise ValueError(f"goal_m: expected finite numbers, got {self.goal_m}")
        if self.route is not None and not (np.isfinite(self.route).all() and np.ptp(self.route, axis=0).any()):
            raise ValueError("route: expected finite waypoints, two of them apart, got others")


@dataclass(frozen=True, slots=True)
class Observation:
    """What a driver sees at one moment: the camera's frame, and what odometry knows of its own car::

        grey = cv2.cvtColor(observation.image, cv2.COLOR_RGB2GRAY)  # (480, 640)
        too_fast = observation.speed_mps > 6.0

    Where the newest frame is late or was dropped, `image` is the last that has arrived, with its own `frame_time_s`.
    """

    image: Image  #: (H, W, 3) RGB, read-only, the last that has arrived; (0, 0, 3) for a driver without images
    time_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    yaw_rate_radps: float
    goal_m: tuple[float, float]
    frame_time_s: float = nan  #: time stamp of the camera, when the image was taken; left out, it is `time_s`
    turn: Turn = "lane"  #: the road to take at a fork, some seconds ahead of it; else "lane"

    def __post_init__(self) -> None:
        if isnan(self.frame_time_s):
            object.__setattr__(self, "frame_time_s", self.time_s)

    @property
    def pose(self) -> Floats:
        """(3,) x m, y m, yaw rad."""
        return np.array([self.x_m, self.y_m, self.yaw_rad])


@dataclass(frozen=True, slots=True)
class Command:
    """What a driver does: throttle in [-1, 1] (negative brakes), steering in [-1, 1] (+ is right, +-1 the limit).

    >>> Command(throttle=0.2, steering=-0.1)  # accelerate a little, to the left
    """

    throttle: float
    steering: float


class Driver(Protocol):
    """What is under test: frames in, throttle and steering out.

    A subclass needs `act` alone. A class of its own needs `privileged`, `reset` and `act`::

        class FollowTheRoad(vpf_sim.Driver):
            def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
                return vpf_sim.Command(throttle=0.2, steering=steering_for(observation.image))
    """

    privileged: Privilege = "none"  #: "route" or "world" if it needs more than its camera and odometry
    uses_images: bool = True  #: False: no frame is drawn for it

    @property
    def needs_next_frame(self) -> bool:
        """Whether it uses the next frame, read after each `act`: a frame that it does not use is not drawn."""
        return True

    def reset(self, setup: DriverSetup) -> None:  # noqa: ARG002
        """Begin an episode."""
        return

    def act(self, observation: Observation) -> Command:
        """The command at one step."""
        ...

    def perceive(self, observation: Observation) -> Perception | None:  # noqa: ARG002
        """What `act` would perceive, without planning; None: its perception is the one of its plan."""
        return None

    def trace(self) -> Plan | None:
        """The plan of the last step, for overlays and scores; None: it shows none."""
        return None

    def uncertainty(self) -> float:
        """How unsure the last command is: above 1 it calls itself unsure; nan: it does not say."""
        return nan
