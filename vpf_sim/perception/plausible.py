"""Replaces readings that cannot be: a yaw rate that jumps as no car turns, a stuck speedometer.

What is plausible passes as it is, to the bit.
"""

from collections import deque
from dataclasses import replace
from math import hypot

from vpf_sim.types import Observation, VehicleModel

YAW_RATE_NOISE_RADPS = 0.15  # of two readings, ten standard deviations of a poor sensor
HELD_S = 0.3  # after which a yaw rate that stays where it jumped to is believed
STUCK_S = 0.3  # for which a speed reads the same, to the bit, and over which the pose's speed is taken
STUCK_MPS, STUCK_SHARE = 0.5, 0.05  # off the pose's, more than a satellite's noise and the sensor's scale


class Plausibility:
    """Watches the speed and the yaw rate, and replaces those that cannot be."""

    def __init__(self, vehicle: VehicleModel) -> None:
        self._turning_per_m = vehicle.steering_rate_limit_radps / vehicle.wheelbase_m
        self._yaw_rate_radps = 0.0  # the last that was believed,
        self._believed_s: float | None = None  # and when
        self._recent: deque[Observation] = deque()  # of the last STUCK_S, oldest first

    def update(self, observation: Observation) -> Observation:
        """The same, at a speed and a yaw rate that can be."""
        yaw_rate = self._yaw_rate(observation)
        speed = self._speed(observation)
        if yaw_rate == observation.yaw_rate_radps and speed == observation.speed_mps:
            return observation
        return replace(observation, yaw_rate_radps=yaw_rate, speed_mps=speed)

    def _yaw_rate(self, observation: Observation) -> float:
        """rad/s, the last one where the reading has jumped by more than the steering can turn the car."""
        told, now_s = observation.yaw_rate_radps, observation.time_s
        if self._believed_s is not None:
            since_s = now_s - self._believed_s
            most = YAW_RATE_NOISE_RADPS + self._turning_per_m * max(observation.speed_mps, 0.0) * since_s
            if abs(told - self._yaw_rate_radps) > most and since_s < HELD_S:
                return self._yaw_rate_radps
        self._yaw_rate_radps, self._believed_s = told, now_s
        return told

    def _speed(self, observation: Observation) -> float:
        """m/s, by the pose where the speedometer reads the same while the pose goes at another pace."""
        recent, told = self._recent, observation.speed_mps
        if recent and recent[-1].speed_mps != told:
            recent.clear()
        recent.append(replace(observation, image=observation.image[:0]))
        while len(recent) > 2 and observation.time_s - recent[1].time_s >= STUCK_S:
            recent.popleft()
        first, time_s = recent[0], observation.time_s - recent[0].time_s
        if time_s < STUCK_S:
            return told
        pace = hypot(observation.x_m - first.x_m, observation.y_m - first.y_m) / time_s
        return pace if abs(pace - told) > STUCK_MPS + STUCK_SHARE * told else told
