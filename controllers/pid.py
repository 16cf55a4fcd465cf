"""The paper's baseline: a waypoint PID with structure, limits and gains of CARLA's agent.

CARLA: PythonAPI/carla/agents/navigation/controller.py and local_planner.py. Lateral: PID on the signed angle from the
heading to the direction of a waypoint ahead. Longitudinal: PID on the speed error in km/h. The integral sums a window
of errors, so it cannot wind up; the steering's change per step is limited.
"""

from collections import deque
from math import atan2

import numpy as np

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.driver_interface import Command, Observation
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats


@settings
class Gains:
    """Gains and limits of CARLA's agent."""

    rate_hz: float = setting("Rate of the controller; the command is held in between.", gt=0.0)
    look_ahead_m: float = setting("Distance below which a waypoint counts as passed.")
    buffer_steps: int = setting("Number of errors that the integral sums.", gt=0)
    lateral_kp: float = setting("Steering for each rad of heading error.")
    lateral_ki: float = setting("Steering for each rad of heading error and second.")
    lateral_kd: float = setting("Steering for each rad/s of heading error.")
    steering_limit: float = setting("Largest share of full steering.", gt=0.0)
    steering_step: float = setting("Largest change of the steering in a step.", gt=0.0)
    longitudinal_kp: float = setting("Throttle for each km/h of speed error.")
    longitudinal_ki: float = setting("Throttle for each km/h of speed error and second.")
    longitudinal_kd: float = setting("Throttle for each km/h of speed error in a second.")
    throttle_limit: float = setting("Largest share of full throttle.")
    brake_limit: float = setting("Largest share of full brake.")


def load_gains() -> Gains:
    """The section [pid] of gains.toml."""
    table = configuration.read("vpf_sim.controllers", "gains.toml")["pid"]
    return configuration.build(Gains, table, "gains.toml: [pid]")


class Pid:
    """A PID law with output in [-1, 1] and a windowed integral."""

    def __init__(self, kp: float, ki: float, kd: float, buffer_steps: int, dt_s: float) -> None:
        self._kp, self._ki, self._kd = kp, ki, kd
        self._dt_s = dt_s
        self._errors: deque[float] = deque(maxlen=buffer_steps)

    def reset(self) -> None:
        self._errors.clear()

    def step(self, error: float) -> float:
        """The control, clipped to [-1, 1]."""
        self._errors.append(error)
        rate = (self._errors[-1] - self._errors[-2]) / self._dt_s if len(self._errors) >= 2 else 0.0
        integral = sum(self._errors) * self._dt_s if len(self._errors) >= 2 else 0.0
        return max(-1.0, min(1.0, self._kp * error + self._ki * integral + self._kd * rate))


class SpeedPid:
    """Keeps a constant speed; runs at its own rate and holds the throttle in between."""

    def __init__(self, gains: Gains, speed_reference_mps: float, rate_hz: float) -> None:
        self._gains = gains
        self._speed_reference_mps = speed_reference_mps
        self._hold_steps = max(1, round(rate_hz / gains.rate_hz))
        law = (gains.longitudinal_kp, gains.longitudinal_ki, gains.longitudinal_kd)
        self._pid = Pid(*law, gains.buffer_steps, self._hold_steps / rate_hz)
        self.reset()

    def reset(self) -> None:
        """Reset the state."""
        self._pid.reset()
        self._step = 0
        self._held = 0.0

    def throttle(self, speed_mps: float) -> float:
        """The throttle for one step of 1 / rate_hz."""
        if self._step % self._hold_steps == 0:
            demand = self._pid.step(3.6 * (self._speed_reference_mps - speed_mps))
            self._held = min(max(demand, -self._gains.brake_limit), self._gains.throttle_limit)
        self._step += 1
        return self._held


class WaypointPid:
    """Follows waypoints (M, 2) m at a constant speed; runs at its own rate and holds the command in between."""

    def __init__(self, gains: Gains, route_m: Floats, speed_reference_mps: float, rate_hz: float) -> None:
        self._gains = gains
        self._route_m = route_m
        self._hold_steps = max(1, round(rate_hz / gains.rate_hz))
        law = (gains.lateral_kp, gains.lateral_ki, gains.lateral_kd)
        self._lateral = Pid(*law, gains.buffer_steps, self._hold_steps / rate_hz)
        self._speed = SpeedPid(gains, speed_reference_mps, rate_hz)
        self.reset()

    def reset(self) -> None:
        """Reset the state to the start of the route."""
        self._lateral.reset()
        self._speed.reset()
        self._step = 0
        self._next = 0
        self._steering = 0.0

    def command(self, observation: Observation) -> Command:
        """The command for one step of 1 / rate_hz."""
        if self._step % self._hold_steps == 0:
            self._steering = self._steer(observation)
        self._step += 1
        return Command(self._speed.throttle(observation.speed_mps), self._steering)

    def _waypoint(self, observation: Observation) -> Floats:
        """(2,) m, the first waypoint beyond the look-ahead; passed waypoints are never revisited."""
        reach = self._gains.look_ahead_m
        position = np.array([observation.x_m, observation.y_m])
        while self._next < len(self._route_m) - 1 and np.hypot(*(self._route_m[self._next] - position)) < reach:
            self._next += 1
        waypoint: Floats = self._route_m[self._next]
        return waypoint

    def _steer(self, observation: Observation) -> float:
        x, y = self._waypoint(observation)
        error = wrap_angle(atan2(y - observation.y_m, x - observation.x_m) - observation.yaw_rad)
        demand = self._lateral.step(error)
        gains = self._gains
        demand = max(self._steering - gains.steering_step, min(self._steering + gains.steering_step, demand))
        return max(-gains.steering_limit, min(gains.steering_limit, demand))
