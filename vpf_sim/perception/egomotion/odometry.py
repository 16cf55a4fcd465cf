"""The car's own way by its speed and yaw rate, where its pose is too rough for that.

All that follows points over a second lives on the way between the two frames: 5 cm aside in a second, as satellite and
inertial navigation drift, turn the direction of a car at 5.55 m/s by half a degree, and a body 15 m ahead is told by
less. Speed and yaw rate, added up, are smooth over such times; they have a scale and a bias, which the pose tells over
longer ones. Where the car is in the world matters to nobody here: what is remembered is remembered relative to where
the car has been.

How rough a pose is shows in itself: what it adds to the way by speed and yaw rate should be the same from one frame to
the next, for scale and bias are. A pose that is smooth is used as it is, to the bit.
"""

from dataclasses import dataclass, replace
from math import atan, cos, exp, sin, sqrt, tan

from vpf_sim.geometry import wrap_angle
from vpf_sim.perception.egomotion.config import OdometryConfig
from vpf_sim.types import Observation, VehicleModel


@dataclass(slots=True)
class _Roughness:
    """How much the excess of a step differs from that of the step before: a scale or a bias is not in it."""

    settle_s: float
    watched_s: float = 0.0
    square: float = 0.0  # mean of the squared changes
    last: float | None = None

    def look(self, excess: float, time_s: float) -> None:
        change = 0.0 if self.last is None else excess - self.last
        self.last = excess
        self.watched_s += time_s
        share = max(1.0 - exp(-time_s / self.settle_s), time_s / self.watched_s)
        self.square += share * (change**2 - self.square)

    @property
    def walk(self) -> float:
        """Variance that a step adds, if the pose is a random walk about the way."""
        return self.square / 2.0

    @property
    def noise(self) -> float:
        """Variance of a pose, if each is off by itself: the change has n_k - 2 n_k-1 + n_k-2."""
        return self.square / 6.0


@dataclass(slots=True)
class _Constant:
    """What the sums of the excess tell of its constant part: Kalman filter of both."""

    variance: float
    value: float = 0.0
    summed: float = 0.0
    filtered: float = 0.0
    filtered_variance: float = 0.0
    mixed: float = 0.0  # covariance

    def tell(self, excess: float, slope: float, noise: float, walk: float, drift: float) -> None:
        """A step's excess, that should be `slope` times the constant; variances that it has and adds."""
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
    """Watches the pose, and goes on by speed and yaw rate from the moment on in which it turns out to be rough.

    The centre of mass moves at yaw + slip, v sin(slip) = l_r d psi / dt (kinematic bicycle).
    """

    def __init__(self, config: OdometryConfig, vehicle: VehicleModel) -> None:
        self._config = config
        self._l_r_m = vehicle.l_r_m
        slip = atan(vehicle.l_r_m / vehicle.wheelbase_m * tan(vehicle.steering_limit_rad))
        self._tightest_per_m = 2.0 * sin(slip) / vehicle.l_r_m  # and as much again for the readings' noise
        calibration = config.calibration
        self._stretch = _Constant(calibration.scale_sd**2 if calibration else 0.0)  # speedometer's scale - 1
        self._bias = _Constant(calibration.bias_sd_radps**2 if calibration else 0.0)
        self._last: Observation | None = None
        self._rough = tuple(_Roughness(config.settle_s) for _ in range(3))  # ahead, aside, turn
        self._pose = (0.0, 0.0, 0.0)
        self.is_needed = False

    def update(self, observation: Observation) -> Observation:
        """The same, at the pose, speed and yaw rate that are believed."""
        last, self._last = self._last, observation
        time_s = 0.0 if last is None else observation.time_s - last.time_s
        if last is not None and time_s > 0.0:
            turn = 0.5 * (last.yaw_rate_radps + observation.yaw_rate_radps) * time_s
            way = 0.5 * (last.speed_mps + observation.speed_mps) * time_s
            self._compare(last, observation, way, turn, time_s)
            if self.is_needed:
                standstill = self._config.standstill
                if standstill is not None and way < standstill.speed_mps * time_s:
                    way = turn = 0.0
                return self._go_on(observation, self.scale * way, turn - self.bias_radps * time_s)
        self._pose = (observation.x_m, observation.y_m, observation.yaw_rad)
        return observation

    @property
    def scale(self) -> float:
        """Way by the pose for each metre by the speed."""
        return 1.0 + self._stretch.value

    @property
    def bias_radps(self) -> float:
        """Of the yaw rate's sensor."""
        return self._bias.value

    def _go_on(self, observation: Observation, way_m: float, turn_rad: float) -> Observation:
        """Goes on by a step; a car that stands does not turn, whatever its sensor says."""
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
        """How rough the pose is, and what it tells of scale and bias."""
        config, (ahead, aside) = self._config, self._parts(way_m, turn_rad)
        turned = wrap_angle(now.yaw_rad - last.yaw_rad)
        cosine, sine = cos(last.yaw_rad + 0.5 * turned), sin(last.yaw_rad + 0.5 * turned)
        x, y = now.x_m - last.x_m, now.y_m - last.y_m
        excess = (cosine * x + sine * y - ahead, cosine * y - sine * x - aside, turned - turn_rad)
        for roughness, one in zip(self._rough, excess, strict=True):
            roughness.look(one, time_s)
        along, across, turning = self._rough
        strays = 0.5 * (along.walk + across.walk) > config.rough_m**2 * time_s
        rough = strays or turning.walk > config.rough_rad**2 * time_s
        self.is_needed = self.is_needed or (rough and turning.watched_s > config.watched_s)
        if (known := config.calibration) is None:
            return
        drift = known.drift_share**2 * time_s
        self._stretch.tell(excess[0], ahead, along.noise, known.walk_m**2 * time_s, drift * known.scale_sd**2)
        self._bias.tell(excess[2], -time_s, turning.noise, known.walk_rad**2 * time_s, drift * known.bias_sd_radps**2)
