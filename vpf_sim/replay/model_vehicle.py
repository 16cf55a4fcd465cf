"""The model vehicle that a driver steers in open loop: a kinematic bicycle.

Nobody carries out the driver's commands on a recording, so its steering integrator would reach its limit. As in the
paper ("the initial speed for the vehicle model is set according to the information provided by the dataset"), a model
carries them out. It starts each segment at the recorded position and speed and stays abreast of the camera: its
lateral motion follows its steering over the recorded distance, its speed is its own.
"""

from dataclasses import dataclass, replace
from math import atan, ceil, cos, sin, tan

import numpy as np

from vpf_sim.controllers.gtsmc import Gains, Gtsmc
from vpf_sim.driver_interface import Command, Observation
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats, Reference, VehicleModel

LEAST_RATE_HZ = 60.0  # of the controller, its design rate; cameras may be slower
MOST_OFFSET_M, MOST_HEADING_ERROR_RAD = (
    3.5,
    0.35,
)  # from the recorded path; beyond it the image no longer fits


@dataclass(frozen=True, slots=True)
class Interval:
    """The recorded poses (3,) x, y, yaw at two consecutive frames, and the time between them."""

    before: Floats
    after: Floats
    seconds: float


class ModelVehicle:
    """A kinematic bicycle and its controller, relative to the recorded path."""

    def __init__(self, gains: Gains, vehicle: VehicleModel, rate_hz: float) -> None:
        self._vehicle = vehicle
        self._rate_hz = rate_hz * ceil(LEAST_RATE_HZ / rate_hz)
        gains = replace(gains, speed_filter_hz=0.0)  # both speeds are exact, and its throttle affects only one
        self._lateral = Gtsmc(gains, vehicle, self._rate_hz)
        self._longitudinal = Gtsmc(gains, vehicle, self._rate_hz)
        self.restart(0.0)

    def restart(self, speed_mps: float) -> None:
        """Return to the recorded position at this speed; the steering angle stays."""
        self.right_m = 0.0  # of the recorded position
        self.turn_rad = 0.0  # its yaw minus the recorded
        self.speed_mps = speed_mps

    @property
    def is_far(self) -> bool:
        """Whether it has left the surroundings that the camera shows."""
        return abs(self.right_m) > MOST_OFFSET_M or abs(self.turn_rad) > MOST_HEADING_ERROR_RAD

    def pose(self, recorded: Floats) -> Floats:
        """(3,) its pose while the recording is at a pose (3,)."""
        x, y, yaw = recorded
        place = np.array([x - self.right_m * sin(yaw), y + self.right_m * cos(yaw)])
        return np.array([*place, wrap_angle(yaw + self.turn_rad)])

    def drive(self, reference: Reference, at: Observation, interval: Interval) -> Command:
        """Mean command until the next frame while following a reference given for `at`."""
        count = max(1, round(interval.seconds * self._rate_hz))
        step_s = interval.seconds / count
        distance_m = float(np.hypot(*(interval.after[:2] - interval.before[:2]))) / count
        yaw_rad, yaw_after_rad = (wrap_angle(float(pose[2])) for pose in (interval.before, interval.after))
        turned_rad = wrap_angle(yaw_after_rad - yaw_rad) / count
        commands = []
        for i in range(count):
            target = _later(reference, i * step_s)
            commands.append(self._command(target, at, yaw_rad + i * turned_rad + self.turn_rad, distance_m / step_s))
            self._move(commands[-1], distance_m, turned_rad, step_s)
        throttle, steering = np.mean([(command.throttle, command.steering) for command in commands], axis=0)
        return Command(float(throttle), float(steering))

    def _command(self, target: Reference, at: Observation, yaw_rad: float, recorded_mps: float) -> Command:
        """Steering at the recorded speed, which moves it along; throttle at its own speed."""

        def observed(speed_mps: float) -> Observation:
            turn = speed_mps * sin(self._slip_rad()) / self._vehicle.l_r_m
            return Observation(at.image, at.time_s, at.x_m, at.y_m, wrap_angle(yaw_rad), speed_mps, turn, at.goal_m)

        steering = self._lateral.command(observed(recorded_mps), target).steering
        return Command(self._longitudinal.command(observed(self.speed_mps), target).throttle, steering)

    def _slip_rad(self) -> float:
        vehicle = self._vehicle
        return atan(vehicle.l_r_m / vehicle.wheelbase_m * tan(self._lateral.steering_rad))

    def _move(self, command: Command, distance_m: float, turned_rad: float, step_s: float) -> None:
        slip, vehicle = self._slip_rad(), self._vehicle
        own_turn = distance_m * sin(slip) / vehicle.l_r_m
        self.right_m += distance_m * sin(self.turn_rad + slip + 0.5 * (own_turn - turned_rad))
        self.turn_rad += own_turn - turned_rad
        self.speed_mps = max(0.0, self.speed_mps + command.throttle * vehicle.full_mps2(command.throttle) * step_s)


def _later(reference: Reference, seconds: float) -> Reference:
    """The reference some seconds after its frame, its heading continued at its rate."""
    rate = reference.heading_rate_radps
    if rate is None:
        return reference
    return Reference(wrap_angle(reference.heading_rad + rate * seconds), reference.speed_mps, rate)
