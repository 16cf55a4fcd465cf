"""Replaces implausible readings: yaw rates that jump faster than a car turns, a stuck speedometer."""

from collections import deque
from dataclasses import replace
from math import hypot

from vpf_sim.configuration import setting, settings
from vpf_sim.driver_interface import Observation
from vpf_sim.types import VehicleModel


@settings
class YawRateCheckConfig:
    noise_radps: float = setting("Largest noise of two samples, ten standard deviations of a poor sensor.", ge=0.0)
    held_s: float = setting("Time after which a lasting jump is accepted.", gt=0.0)


@settings
class SpeedCheckConfig:
    stuck_s: float = setting("Time without any change of the speed, over which the pose's speed is measured.", gt=0.0)
    error_mps: float = setting("Largest difference to the pose's speed; `error_share` adds to it.", ge=0.0)
    error_share: float = setting("Share of the measured speed that adds to the largest difference.", ge=0.0)


@settings
class PlausibilityConfig:
    yaw_rate: YawRateCheckConfig = setting("Replaces yaw rates that jump.")
    speed: SpeedCheckConfig = setting("Replaces a stuck speed by that of the pose.")


class Plausibility:
    """Checks the speed and the yaw rate of each observation."""

    def __init__(self, config: PlausibilityConfig, vehicle: VehicleModel) -> None:
        self._config = config
        self._turning_per_m = vehicle.steering_rate_limit_radps / vehicle.wheelbase_m
        self._yaw_rate_radps = 0.0  # last accepted,
        self._accepted_s: float | None = None  # and when
        self._recent: deque[Observation] = deque()  # while the speed reads the same, oldest first

    def update(self, observation: Observation) -> Observation:
        """The observation with a plausible speed and yaw rate; plausible ones are returned as they are."""
        yaw_rate = self._yaw_rate(observation)
        speed = self._speed(observation)
        if yaw_rate == observation.yaw_rate_radps and speed == observation.speed_mps:
            return observation
        return replace(observation, yaw_rate_radps=yaw_rate, speed_mps=speed)

    def _yaw_rate(self, observation: Observation) -> float:
        """rad/s, the last accepted one if the reading jumped by more than the steering can turn the car."""
        config, measured, now_s = self._config.yaw_rate, observation.yaw_rate_radps, observation.time_s
        if self._accepted_s is not None:
            since_s = now_s - self._accepted_s
            most = config.noise_radps + self._turning_per_m * max(observation.speed_mps, 0.0) * since_s
            if abs(measured - self._yaw_rate_radps) > most and since_s < config.held_s:
                return self._yaw_rate_radps
        self._yaw_rate_radps, self._accepted_s = measured, now_s
        return measured

    def _speed(self, observation: Observation) -> float:
        """m/s, by the pose if the speedometer is stuck and the pose moves at another speed."""
        config, recent, measured = self._config.speed, self._recent, observation.speed_mps
        if recent and recent[-1].speed_mps != measured:
            recent.clear()
        recent.append(replace(observation, image=observation.image[:0]))
        while len(recent) > 2 and observation.time_s - recent[1].time_s >= config.stuck_s:
            recent.popleft()
        first, time_s = recent[0], observation.time_s - recent[0].time_s
        if time_s < config.stuck_s:
            return measured
        pace = hypot(observation.x_m - first.x_m, observation.y_m - first.y_m) / time_s
        return pace if abs(pace - measured) > config.error_mps + config.error_share * measured else measured
