"""A world of one straight line, with the interface that the episode loop knows: all in it is plain arithmetic."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.scenarios.parts import Road
from vpf_sim.types import Camera, VehicleModel

RATE_HZ = 10.0
LENGTH_M = 10.0


class TinyWorld:
    """A car moves `throttle` m a step along x and `steering` m to the right; the goal is 10 m ahead."""

    camera = Camera(width_px=8, height_px=6)
    vehicle_model = VehicleModel()
    rate_hz = RATE_HZ
    speed_reference_mps = 5.0
    goal_m = (LENGTH_M, 0.0)
    route_length_m = LENGTH_M
    nearest = (np.inf, None)
    renderer = None

    def __init__(self, invalid_after: int | None = None) -> None:
        from vpf_sim.envs.road import Carriageway

        self.invalid_after = invalid_after
        straight = Road.model_validate({"start_m": [-100.0, 0.0], "segments": [{"kind": "line", "length_m": 300.0}]})
        self.road = SimpleNamespace(network=Carriageway(straight), vehicles=[], objects=[])
        self.route = np.column_stack([np.arange(0.0, 60.0), np.zeros(60)])

    def reset(self, seed: int) -> tuple[dict[str, Any], dict[str, Any]]:
        self.seed, self.steps = seed, 0
        self.looks: list[bool] = []
        self.ego: Any = SimpleNamespace(
            position=np.zeros(2), heading=0.0, velocity=np.zeros(2), LENGTH=4.5, WIDTH=1.9, place=(0.0, 0.0)
        )
        self.ego.road = self.road
        return self._observed(), self._info("invalid_frame" if self.invalid_after == 0 else "running")

    def step(self, action: Any, *, with_frame: bool = True) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        self.steps += 1
        self.looks.append(with_frame)
        self.ego.position = self.ego.position + np.asarray(action, float)
        success, invalid = self.ego.position[0] >= LENGTH_M, self.steps == self.invalid_after
        status = "invalid_frame" if invalid else "success" if success else "running"
        return self._observed(), 0.0, bool(success and not invalid), bool(invalid), self._info(status)

    def _observed(self) -> dict[str, Any]:
        image = np.full((6, 8, 3), (self.seed + self.steps) % 256, np.uint8)
        ego = np.array([*self.ego.position, 0.0, RATE_HZ, 0.0])
        seen = {"image": image} if all(self.looks[-1:]) else {}
        return {**seen, "ego": ego, "goal": np.array(self.goal_m), "time": np.array([self.steps / RATE_HZ])}

    def _info(self, status: str) -> dict[str, Any]:
        x, y = self.ego.position.tolist()
        return {
            "status": status,
            "route_m": x,
            "lane_offset_m": y,
            "clearance_m": np.inf,
            "collided_with": None,
            "invalid_frame": {"frame": self.steps, "time_s": self.steps / RATE_HZ, "fault": "stale"},
            "secret": "what drivers must not see",
        }


class Constant:
    """A driver that always does the same, and remembers all that it was shown."""

    privileged: Any = "none"

    def __init__(self, throttle: float = 1.0, steering: float = 0.0) -> None:
        self.command = Command(throttle, steering)
        self.seen: list[Observation] = []

    def reset(self, setup: DriverSetup) -> None:
        self.setup = setup
        self.seen = []

    def act(self, observation: Observation) -> Command:
        self.seen.append(observation)
        return self.command
