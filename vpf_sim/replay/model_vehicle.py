"""The model vehicle that a driver steers in open loop, a kinematic bicycle; and the segments of its drive.

A recording does not carry out the driver's commands, so its steering integrator would reach its limit. As in the
paper ("the initial speed for the vehicle model is set according to the information provided by the dataset"), a model
carries them out. It starts each segment at the recorded position and speed and keeps level with the camera: its
lateral motion follows its steering over the recorded distance, its speed is its own. As in the paper, the goal is the
last pose of the segment, and the speed to keep is the recorded one at its start.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import atan, ceil, cos, sin, tan

import numpy as np

from vpf_sim.controllers.gtsmc import Gains, Gtsmc
from vpf_sim.driver_interface import Command, Observation
from vpf_sim.geometry import wrap_angle
from vpf_sim.replay.recording import Recording
from vpf_sim.types import Floats, Reference, VehicleModel

LEAST_RATE_HZ = 60.0  # of the controller, its design rate; cameras may be slower
MOST_OFFSET_M, MOST_HEADING_ERROR_RAD = (
    3.5,
    0.35,
)  # from the recorded path; beyond it the image no longer fits
LONGEST_S = 20.0
AHEAD_M = 100.0  # to the goal on the current course, without poses
BEYOND_M = 40.0  # of route past the last pose
GOAL_POSE = "the last pose of each segment"
GOAL_AHEAD = f"{AHEAD_M:g} m ahead on the course at the start of each segment"


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

    def yaw_rate_radps(self, speed_mps: float) -> float:
        """Its yaw rate at a speed, by its steering angle."""
        return speed_mps * sin(self._slip_rad()) / self._vehicle.l_r_m

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
            turn = self.yaw_rate_radps(speed_mps)
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


@dataclass(frozen=True, slots=True)
class Segment:
    """The frames `first` <= k < `stop`."""

    first: int
    stop: int
    goal_m: tuple[float, float]
    speed_mps: float


def segments(recording: Recording) -> list[Segment]:
    """Equal parts of at most LONGEST_S; a part also ends where an obstacle label changes."""
    labels = recording.obstacle
    same = (labels[1:] == labels[:-1]) | (np.isnan(labels[1:]) & np.isnan(labels[:-1]))
    changes = [0, *(np.flatnonzero(~same) + 1).tolist(), len(recording)]
    found = []
    for first, stop in pairwise(changes):
        duration = recording.times_s[stop - 1] - recording.times_s[first]
        count = max(1, int(np.ceil(duration / LONGEST_S)))
        found += [(int(part[0]), int(part[-1]) + 1) for part in np.array_split(np.arange(first, stop), count)]
    return [Segment(first, stop, _goal(recording, first, stop), _speed(recording, first)) for first, stop in found]


def has_poses(recording: Recording) -> bool:
    """Whether the poses are recorded or derived."""
    return recording.origins["poses"].is_known


def goal_text(recording: Recording) -> str:
    """What the goals are, for the table."""
    return GOAL_POSE if has_poses(recording) else GOAL_AHEAD


def route(poses: Floats) -> Floats:
    """(M, 2) m, points 1 m apart along the driven path and straight on."""
    heading = poses[-1, 2]
    beyond = poses[-1, :2] + BEYOND_M * np.array([np.cos(heading), np.sin(heading)])
    points = np.vstack([poses[:, :2], beyond])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    stations = np.arange(0.0, along[-1], 1.0)
    return np.stack([np.interp(stations, along, points[:, i]) for i in range(2)], axis=1)


def _goal(recording: Recording, first: int, stop: int) -> tuple[float, float]:
    x, y, yaw = (float(value) for value in recording.poses[first])
    if has_poses(recording):
        return float(recording.poses[stop - 1, 0]), float(recording.poses[stop - 1, 1])
    return x + AHEAD_M * cos(yaw), y + AHEAD_M * sin(yaw)


def _speed(recording: Recording, first: int) -> float:
    """m/s; 0 for a car that rolls back."""
    return max(float(recording.speed_mps[first]), 0.0)
