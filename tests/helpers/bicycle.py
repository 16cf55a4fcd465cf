"""The kinematic bicycle of the paper, about its centre of mass, for closed loops without a camera."""

from dataclasses import dataclass, field
from math import atan, cos, sin, tan

import numpy as np

from vpf_sim.driver_interface import Command, Observation
from vpf_sim.types import VehicleModel


@dataclass
class Bicycle:
    """x, y m; yaw rad; speed m/s. `step` integrates by Euler's rule at `rate_hz`."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    speed_mps: float = 5.55
    rate_hz: float = 60.0
    steering_rad: float = 0.0
    yaw_rate_radps: float = 0.0
    time_s: float = 0.0
    model: VehicleModel = field(default_factory=VehicleModel)

    def step(self, command: Command) -> None:
        model, dt = self.model, 1.0 / self.rate_hz
        most = model.steering_rate_limit_radps * dt
        wish = command.steering * model.steering_limit_rad
        self.steering_rad += min(max(wish - self.steering_rad, -most), most)
        full = model.full_throttle_mps2 if command.throttle > 0.0 else model.full_brake_mps2
        self.speed_mps = max(0.0, self.speed_mps + full * command.throttle * dt)
        slip = atan(model.l_r_m * tan(self.steering_rad) / model.wheelbase_m)
        self.yaw_rate_radps = self.speed_mps * sin(slip) / model.l_r_m
        self.x_m += self.speed_mps * cos(self.yaw_rad + slip) * dt
        self.y_m += self.speed_mps * sin(self.yaw_rad + slip) * dt
        self.yaw_rad += self.yaw_rate_radps * dt
        self.time_s += dt

    def observe(self, goal_m: tuple[float, float] = (1e3, 0.0)) -> Observation:
        blank = np.zeros((1, 1, 3), np.uint8)
        state = (self.x_m, self.y_m, self.yaw_rad, self.speed_mps, self.yaw_rate_radps)
        return Observation(blank, self.time_s, *state, goal_m)
