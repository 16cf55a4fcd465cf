"""Odometry by speed and yaw rate, which replaces a pose that is too rough.

Depth from motion needs the way between two frames to centimetres. Satellite and inertial navigation drifts by 5 cm a
second, which turns the direction of a car at 5.55 m/s by half a degree. Integrated speed and yaw rate are smooth over
a second; their scale and bias follow from the pose over longer times. The place in the world does not matter: obstacles
are stored relative to the way.

The difference between the motion by the pose and by speed and yaw rate should be the same in consecutive frames, as
scale and bias are. Its changes measure how rough the pose is. A smooth pose is used as it is, to the bit.
"""

from dataclasses import dataclass, replace
from math import atan, cos, exp, sin, sqrt, tan

from vpf_sim.driver_interface import Observation
from vpf_sim.geometry import wrap_angle
from vpf_sim.perception.egomotion.egomotion_settings import OdometryConfig
from vpf_sim.types import VehicleModel


@dataclass(slots=True)
class _Roughness:
    """Changes of the excess from step to step, which no scale or bias explains."""

    settle_s: float
    watched_s: float = 0.0
    square: float = 0.0  # mean of the squared changes
    last: float | None = None

    def update(self, excess: float, time_s: float) -> None:
        change = 0.0 if self.last is None else excess - self.last
        self.last = excess
        self.watched_s += time_s
        share = max(1.0 - exp(-time_s / self.settle_s), time_s / self.watched_s)
        self.square += share * (change**2 - self.square)

    @property
    def walk(self) -> float:
        """Variance that a step adds if the pose is a random walk about the true way."""
        return self.square / 2.0

    @property
    def noise(self) -> float:
        """Variance of a pose if errors are independent: the change has n_k - 2 n_k-1 + n_k-2."""
        return self.square / 6.0


@dataclass(slots=True)
class _Constant:
    """Kalman filter of the summed excess and its constant part."""

    variance: float
    value: float = 0.0
    summed: float = 0.0
    filtered: float = 0.0
    filtered_variance: float = 0.0
    mixed: float = 0.0  # covariance

    def update(self, excess: float, slope: float, noise: float, walk: float, drift: float) -> None:
        """Add a step's excess, `slope` times the constant, with its noise; `walk` and `drift` are process noise."""
        self.summed += excess
        self.filtered += slope * self.value
        self.filtered_variance += slope * (2.0 * self.mixed + slope * self.variance) + walk
        self.mixed += slope * self.variance
        self.variance += drift
        error, total = self.summed - self.filtered, self.filtered_variance + noise
        gains = self.filtered_variance / total, self.mixed / total
        self.filtered += gains[0] * error
        self.value += gains[1] * error
        self.variance -= gains[1] * self.mixed
        self.mixed -= gains[0] * self.mixed
        self.filtered_variance -= gains[0] * self.filtered_variance


class Odometry:
    """Checks the pose, and replaces it by integrated speed and yaw rate once it is rough.

    The centre of mass moves at yaw + slip, v sin(slip) = l_r d psi / dt (kinematic bicycle).
    """

    def __init__(self, config: OdometryConfig, vehicle: VehicleModel) -> None:
        self._config = config
        self._l_r_m = vehicle.l_r_m
        slip = atan(vehicle.l_r_m / vehicle.wheelbase_m * tan(vehicle.steering_limit_rad))
        self._tightest_per_m = 2.0 * sin(slip) / vehicle.l_r_m  # twice the limit, for the readings' noise
        self._stretch = _Constant(config.calibration.scale_sd**2)  # speedometer's scale - 1
        self._bias = _Constant(config.calibration.bias_sd_radps**2)
        self._last: Observation | None = None
        self._rough = tuple(_Roughness(config.settle_s) for _ in range(3))  # ahead, aside, turn
        self._pose = (0.0, 0.0, 0.0)
        self.is_needed = False

    def update(self, observation: Observation) -> Observation:
        """The observation with the pose, speed and yaw rate to use."""
        last, self._last = self._last, observation
        time_s = 0.0 if last is None else observation.time_s - last.time_s
        if last is not None and time_s > 0.0:
            turn = 0.5 * (last.yaw_rate_radps + observation.yaw_rate_radps) * time_s
            way = 0.5 * (last.speed_mps + observation.speed_mps) * time_s
            self._compare(last, observation, way, turn, time_s)
            if self.is_needed:
                if way < self._config.standstill_mps * time_s:
                    way = turn = 0.0  # noise of the sensors would move a standing vehicle
                return self._integrated(observation, self.scale * way, turn - self.bias_radps * time_s)
        self._pose = (observation.x_m, observation.y_m, observation.yaw_rad)
        return observation

    @property
    def scale(self) -> float:
        """True speed over the speedometer's."""
        return 1.0 + self._stretch.value

    @property
    def bias_radps(self) -> float:
        """Bias of the yaw rate."""
        return self._bias.value

    def _integrated(self, observation: Observation, way_m: float, turn_rad: float) -> Observation:
        """The observation a step on; a standing car does not turn, whatever the yaw rate."""
        most = self._tightest_per_m * way_m
        turn_rad = min(max(turn_rad, -most), most)
        ahead, aside = self._parts(way_m, turn_rad)
        x, y, yaw = self._pose
        cosine, sine = cos(yaw + 0.5 * turn_rad), sin(yaw + 0.5 * turn_rad)
        x, y = x + ahead * cosine - aside * sine, y + ahead * sine + aside * cosine
        self._pose = (x, y, wrap_angle(yaw + turn_rad))
        return replace(
            observation,
            x_m=x,
            y_m=y,
            yaw_rad=self._pose[2],
            speed_mps=self.scale * observation.speed_mps,
            yaw_rate_radps=observation.yaw_rate_radps - self.bias_radps,
        )

    def _parts(self, way_m: float, turn_rad: float) -> tuple[float, float]:
        """m ahead and aside, in the axes of half the turn."""
        aside = self._l_r_m * turn_rad
        return sqrt(max(way_m**2 - aside**2, 0.0)), aside

    def _compare(self, last: Observation, now: Observation, way_m: float, turn_rad: float, time_s: float) -> None:
        """Update roughness, scale and bias by one step."""
        config, (ahead, aside) = self._config, self._parts(way_m, turn_rad)
        turned = wrap_angle(now.yaw_rad - last.yaw_rad)
        cosine, sine = cos(last.yaw_rad + 0.5 * turned), sin(last.yaw_rad + 0.5 * turned)
        x, y = now.x_m - last.x_m, now.y_m - last.y_m
        excess = (cosine * x + sine * y - ahead, cosine * y - sine * x - aside, turned - turn_rad)
        for roughness, one in zip(self._rough, excess, strict=True):
            roughness.update(one, time_s)
        along, across, turning = self._rough
        strays = 0.5 * (along.walk + across.walk) > config.rough_m**2 * time_s
        rough = strays or turning.walk > config.rough_rad**2 * time_s
        self.is_needed = self.is_needed or (rough and turning.watched_s > config.watched_s)
        known, drift = config.calibration, config.calibration.drift_share**2 * time_s
        self._stretch.update(excess[0], ahead, along.noise, known.walk_m**2 * time_s, drift * known.scale_sd**2)
        self._bias.update(excess[2], -time_s, turning.noise, known.walk_rad**2 * time_s, drift * known.bias_sd_radps**2)
