"""One body that moves: where its face is, how fast it drives along the road, and how sure that is."""

from dataclasses import dataclass
from math import exp

import numpy as np

from vpf_sim.geometry import rotation, vehicle_from_world, world_from_vehicle
from vpf_sim.types import Camera, Floats


@dataclass(frozen=True, slots=True)
class Sight:
    """One frame's measurement of a body."""

    depth_m: float  # of the road behind its lowest point, from the camera
    speed_mps: float  # along the road
    sigma_mps: float
    left_m: float  # its sides, right of the vehicle's axis
    right_m: float
    top_m: float  # its highest point above the road


@dataclass(frozen=True, slots=True)
class FilterConfig:
    """Noise of the measurements and of the body's own driving."""

    foot_px: float = 1.5  # standard deviation of the foot's row
    foot_ratio: float = 0.04  # and of its depth, as a share
    foot_hidden: float = 6.0  # times as much where the foot seems farther: the lowest point need not be the foot
    acceleration_mps2: float = 1.0  # over a second
    slip_mps: float = 0.3  # of the place, what the model does not know
    side_s: float = 0.2  # time constant of the sides
    narrowest_m: float = 1.7  # vehicle, and
    widest_m: float = 2.6
    clip: float = 2.0  # standard deviations of an innovation that are taken


class Mover:
    """A Kalman filter on the distance and the speed along the road, and a first-order filter on the place across.

    It lives in the world, so what is not seen for a while is predicted: along the road at its speed.
    """

    def __init__(self, sight: Sight, camera: Camera, pose: Floats, time_s: float, config: FilterConfig) -> None:
        self._camera, self._config = camera, config
        self.speed_mps = sight.speed_mps
        self.width_m = sight.right_m - sight.left_m  # as it is seen
        middle = 0.5 * (sight.right_m + sight.left_m)
        self._place_m = world_from_vehicle(np.array([camera.forward_m + sight.depth_m, middle]), pose)
        self._covariance = np.diag([(0.2 * sight.depth_m) ** 2, sight.sigma_mps**2])
        self.hits = 1
        self.seen_s = time_s
        self.identity: int | None = None  # once it is believed

    def predict(self, dt_s: float, direction_rad: float) -> None:
        """dt seconds on along the road, which runs in that direction of the world there."""
        self._place_m = self._place_m + self.speed_mps * dt_s * rotation(direction_rad)[:, 0]
        step = np.array([[1.0, dt_s], [0.0, 1.0]])
        config = self._config
        noise = np.diag([config.slip_mps**2 * dt_s, config.acceleration_mps2**2 * dt_s])
        self._covariance = step @ self._covariance @ step.T + noise

    def place(self, pose: Floats) -> tuple[float, float]:
        """Forward m of the face and right m of its middle, in the axes of the vehicle."""
        forward, right = vehicle_from_world(self._place_m, pose)
        return float(forward), float(right)

    @property
    def sigma_m(self) -> float:
        return float(np.sqrt(self._covariance[0, 0]))

    @property
    def sigma_mps(self) -> float:
        return float(np.sqrt(self._covariance[1, 1]))

    def update(self, sight: Sight, pose: Floats, time_s: float, dt_s: float) -> None:
        """One frame's measurement, dt seconds after the last frame."""
        config = self._config
        forward, right = self.place(pose)
        state = np.array([forward - self._camera.forward_m, self.speed_mps])
        foot = sight.depth_m
        sigma = foot * (config.foot_ratio + config.foot_px * foot / (self._camera.fy_px * self._camera.height_m))
        sigma *= config.foot_hidden if foot > state[0] else 1.0
        state = self._correct(state, foot - state[0], np.array([1.0, 0.0]), sigma)
        state = self._correct(state, sight.speed_mps - state[1], np.array([0.0, 1.0]), sight.sigma_mps)
        self.speed_mps = max(float(state[1]), 0.0)
        depth = max(float(state[0]), 0.5)
        gain = 1.0 - exp(-dt_s / config.side_s)
        right += gain * (0.5 * (sight.left_m + sight.right_m) - right)
        self.width_m += gain * (sight.right_m - sight.left_m - self.width_m)
        self._place_m = world_from_vehicle(np.array([self._camera.forward_m + depth, right]), pose)
        self.hits, self.seen_s = self.hits + 1, time_s

    @property
    def half_m(self) -> float:
        """m, half the width that it takes: what is seen, as wide as a vehicle is."""
        return 0.5 * min(max(self.width_m, self._config.narrowest_m), self._config.widest_m)

    def _correct(self, state: Floats, innovation: float, slope: Floats, sigma: float) -> Floats:
        reach = self._covariance @ slope
        variance = float(slope @ reach) + sigma**2
        limit = self._config.clip * float(np.sqrt(variance))
        gain = reach / variance
        self._covariance = self._covariance - np.outer(gain, reach)
        corrected: Floats = state + gain * min(max(innovation, -limit), limit)
        return corrected
