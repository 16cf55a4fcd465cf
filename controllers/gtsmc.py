"""The gradient-tracking sliding mode controller (GTSMC): follows a reference heading and speed.

Lateral, with psi_e = psi - psi_d and the steering actuator as an integrator:

    s_r = c_r psi_e + d psi_e / dt,    d delta / dt = u = -u_0 sign(s_r),    |delta| <= delta_0.

Longitudinal: s_l = c_l v - v_d, a = -a_0 sign(s_l). With a boundary layer, sign(s) becomes clip(s / layer, -1, 1). The
second-order law (`super_twisting`) replaces the lateral sign.

`feedforward` adds the reference's part of the equivalent control (Utkin, Sliding Modes in Control and Optimization,
1992, ch. 2) to u: L v db / ds for the curvature b = (d psi_d / dt) / v. Without it, a changing curvature leaves an
error inside the layer. A planned acceleration, where the reference has one, is added to a for the same reason.

In the layer, with slope k = u_0 / layer, psi_e'' + k v / L psi_e' + c_r k v / L psi_e = 0 has the damping ratio
sqrt(k v / (4 c_r L)). `layer_narrows_below_mps` keeps it constant at low speed.

Reaching condition: d s_r / dt = (v / L) u + phi with phi = c_r d psi_e / dt - d^2 psi_d / dt^2, so the manifold is
reached only while the authority u_0 v / L exceeds |phi|. At standstill the steering has no authority and is held. On a
road with the curvature rate k' phi is k' v^2, which grows faster with speed than the authority. With `slows_to_reach`
the car slows down to v authority / |phi|, at which the condition holds.
"""

from collections import deque
from dataclasses import dataclass, replace
from math import atan, copysign, exp, inf, pi, sin, tan
from typing import Literal

from vpf_sim import configuration
from vpf_sim.braking import hard_excess
from vpf_sim.configuration import setting, settings
from vpf_sim.controllers.super_twisting import SuperTwisting
from vpf_sim.driver_interface import Command, Observation
from vpf_sim.errors import unknown_name
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Reference, VehicleModel


class ChangeLimit:
    """The recent acceleration commands."""

    def __init__(self, limit_mps2: float, window_s: float, dt_s: float) -> None:
        self._limit_mps2 = limit_mps2
        self._last: deque[float] = deque(maxlen=max(1, round(window_s / dt_s)))

    def reset(self) -> None:
        """Forget the recent commands, for emergency braking."""
        self._last.clear()

    def limit(self, demand_mps2: float) -> float:
        """m/s2, the demand clipped to the limit; call once per step."""
        if self._last:
            demand_mps2 = min(max(demand_mps2, max(self._last) - self._limit_mps2), min(self._last) + self._limit_mps2)
        self._last.append(demand_mps2)
        return demand_mps2


STANDSTILL_MPS = 0.1
SLOWEST_MPS = 2.0  # lowest speed for the reaching condition: less speed means less authority
RECOVERY_MPS2 = 1.5  # rise of the speed limit once the condition holds again
DEMAND_FILTER_HZ = 2.0
MIN_LAYER_SHARE = 0.15  # least share of the boundary layer: a narrower one amplifies sensor noise
MAX_RAD, MAX_RADPS, MAX_MPS, MAX_MPS2 = 1e6, 1e3, 1e3, 1e3  # input limits, so that filters and derivatives stay finite


@settings
class Gains:
    """One set of gains."""

    c_r_per_s: float = setting("Slope c_r of the rotational sliding manifold.", gt=0.0)
    u0_radps: float = setting("Rate u_0 of the steering actuator.", gt=0.0)
    boundary_layer_radps: float = setting("Boundary layer of s_r; 0 takes the printed sign function.", ge=0.0)
    reference_filter_hz: float = setting(
        "Cut-off of the low-pass filter of the differentiated heading reference; 0 filters nothing.", ge=0.0
    )
    c_l: float = setting("Gain c_l: the speed converges to v_d / c_l.", gt=0.0)
    a0_mps2: float = setting("Acceleration a_0 when the car speeds up.", gt=0.0)
    brake_a0_mps2: float = setting("Deceleration a_0 when the car slows down.", gt=0.0)
    speed_boundary_layer_mps: float = setting("Boundary layer of s_l; 0 takes the printed sign function.", ge=0.0)
    yaw_rate_filter_hz: float = setting(
        "Frequency below which the sensor gives the yaw rate, above it the bicycle model; 0 takes the sensor alone.",
        default=0.0,
        ge=0.0,
    )
    speed_filter_hz: float = setting(
        "Frequency below which the sensor gives the speed, above it the pedals; 0 takes the sensor alone.",
        default=0.0,
        ge=0.0,
    )
    lateral_law: Literal["first_order", "super_twisting"] = setting(
        "Control law of the steering.", default="first_order"
    )
    disturbance_radps3: float = setting(
        "Largest rate D of the disturbance that the super-twisting law rejects.", default=0.0
    )
    slows_to_reach: bool = setting(
        "Whether the car slows down where the reaching condition does not hold.", default=False
    )
    layer_narrows_below_mps: float = setting(
        "Speed below which the layer of s_r narrows with the steering authority, against oscillation.",
        default=0.0,
        ge=0.0,
    )
    hard_braking_error_mps: float = setting(
        "Speed error from which the brake exceeds a_0, to its full 1 m/s later; 0 never exceeds it.",
        default=0.0,
        ge=0.0,
    )
    change_limit_mps2: float = setting(
        "Largest change of the acceleration within `change_window_s`; 0 sets no limit.", default=0.0, ge=0.0
    )
    change_window_s: float = setting(
        "Time in which the acceleration may change by `change_limit_mps2`.", default=0.0, ge=0.0
    )
    feedforward: bool = setting("Whether the bends of the reference are added to the steering rate.", default=False)

    def __post_init__(self) -> None:
        if (self.lateral_law == "super_twisting") != (self.disturbance_radps3 > 0.0):
            raise ValueError(
                f"disturbance_radps3: expected > 0 with super_twisting alone, got {self.disturbance_radps3}"
            )
        if (self.change_limit_mps2 > 0.0) != (self.change_window_s > 0.0):
            got = f"{self.change_limit_mps2}, {self.change_window_s}"
            raise ValueError(f"change_limit_mps2, change_window_s: expected both > 0 or both 0, got {got}")


@dataclass(frozen=True, slots=True)
class Reaching:
    """The reaching condition of the sliding mode."""

    authority_radps2: float  # u_0 v / L
    demand_radps2: float  # |phi|, low-passed

    @property
    def holds(self) -> bool:
        return self.demand_radps2 <= self.authority_radps2


def load_gains(name: str) -> Gains:
    """The set [gtsmc.`name`] of gains.toml."""
    sets = configuration.read("vpf_sim.controllers", "gains.toml")["gtsmc"]
    if name not in sets:
        raise unknown_name("gains", name, sets)
    return configuration.build(Gains, sets[name], f"gains.toml: [gtsmc.{name}]")


def relay(s: float, layer: float) -> float:
    """sign(s), or the saturation s / layer in a boundary layer; 0 at 0."""
    if layer > 0.0:
        return max(-1.0, min(1.0, s / layer))
    return copysign(1.0, s) if s else 0.0


class Gtsmc:
    """The controller with its actuator state and filters."""

    def __init__(self, gains: Gains, vehicle: VehicleModel, rate_hz: float) -> None:
        self._gains = gains
        self._vehicle = vehicle
        self._dt_s = 1.0 / rate_hz
        self.reset()

    def reset(self) -> None:
        """Reset all state, with straight wheels."""
        self.steering_rad = 0.0
        self._last_heading_rad: float | None = None
        self._heading_rate_radps = 0.0
        self._last_rate_radps: float | None = None
        self._last_curvature_per_m: float | None = None
        self._demand_radps2, self._curvature_demand_radps2 = 0.0, 0.0
        self.yaw_rate_radps, self._model_radps = 0.0, 0.0
        self.reaching = Reaching(0.0, 0.0)
        self.speed_mps: float | None = None
        self._acceleration_mps2 = 0.0  # last command
        self._reachable_mps = inf  # limit of v_d by the reaching condition
        limits_change = self._gains.change_limit_mps2 > 0.0
        self._change_limit = (
            ChangeLimit(self._gains.change_limit_mps2, self._gains.change_window_s, self._dt_s)
            if limits_change
            else None
        )
        is_second_order = self._gains.lateral_law == "super_twisting"
        self._twisting = SuperTwisting(self._gains.disturbance_radps3, self._dt_s) if is_second_order else None

    def command(self, observation: Observation, reference: Reference) -> Command:
        """The command for one step of 1 / rate_hz."""
        reference = _bounded(reference)
        speed_mps = self._filtered_speed(observation.speed_mps)
        measured_radps = min(max(observation.yaw_rate_radps, -MAX_RADPS), MAX_RADPS)
        yaw_rate = self._yaw_rate(measured_radps, speed_mps)
        observation = replace(observation, speed_mps=speed_mps, yaw_rate_radps=yaw_rate)
        steering = self._steer(observation, reference)
        target_mps = self._speed(speed_mps, reference.speed_mps)
        self._acceleration_mps2 = self._accelerate(speed_mps, target_mps, reference.acceleration_mps2)
        throttle = self._acceleration_mps2 / self._vehicle.full_mps2(self._acceleration_mps2)
        return Command(throttle, steering / self._vehicle.steering_limit_rad)

    def manifold(self, observation: Observation, reference: Reference, heading_rate_radps: float) -> float:
        """The sliding variable s_r, rad/s."""
        error = wrap_angle(observation.yaw_rad - reference.heading_rad)
        return self._gains.c_r_per_s * error + observation.yaw_rate_radps - heading_rate_radps

    def _steer(self, observation: Observation, reference: Reference) -> float:
        """The actuator's angle after one step, rad; clamping the integrator prevents windup."""
        rate = self._reference_rate(reference)
        authority = observation.speed_mps / self._vehicle.wheelbase_m
        self._update_reaching(observation, reference, rate, authority)
        if observation.speed_mps > STANDSTILL_MPS:
            s_r, rate_limit = self.manifold(observation, reference, rate), self._gains.u0_radps
            demand = self._rate(s_r, authority, observation.speed_mps) + self._feedforward_rate(
                authority, observation.speed_mps
            )
            step = max(-rate_limit, min(rate_limit, demand)) * self._dt_s
            limit = self._vehicle.steering_limit_rad
            self.steering_rad = max(-limit, min(limit, self.steering_rad + step))
        return self.steering_rad

    def _rate(self, s_r: float, authority_per_s: float, speed_mps: float) -> float:
        """The steering rate u, rad/s."""
        if self._twisting is not None:
            return self._twisting.rate(s_r, authority_per_s, self._gains.u0_radps)
        layer, narrows_below_mps = self._gains.boundary_layer_radps, self._gains.layer_narrows_below_mps
        if speed_mps < narrows_below_mps:
            layer *= max(speed_mps / narrows_below_mps, MIN_LAYER_SHARE)
        return -self._gains.u0_radps * relay(s_r, layer)

    def _curvature_demand(self, observation: Observation, reference: Reference) -> float:
        """rad/s^2, v^2 db / ds of the reference curvature b = (d psi_d / dt) / v.

        0 without a given rate: a heading differentiated twice is noise.
        """
        if reference.heading_rate_radps is None:
            return 0.0
        speed = max(observation.speed_mps, STANDSTILL_MPS)
        curvature = reference.heading_rate_radps / speed
        last, self._last_curvature_per_m = self._last_curvature_per_m, curvature
        return 0.0 if last is None else speed * (curvature - last) / self._dt_s

    def _feedforward_rate(self, authority_per_s: float, speed_mps: float) -> float:
        """Feedforward steering rate, rad/s; reduced at low speed, where the authority is small."""
        if not self._gains.feedforward:
            return 0.0
        narrows_below_mps = self._gains.layer_narrows_below_mps
        share = speed_mps / narrows_below_mps if speed_mps < narrows_below_mps else 1.0
        return share * self._curvature_demand_radps2 / authority_per_s

    def _update_reaching(
        self, observation: Observation, reference: Reference, rate_radps: float, authority_per_s: float
    ) -> None:
        """Update the reaching condition; phi contains a numerical derivative, so it is low-passed."""
        last, self._last_rate_radps = self._last_rate_radps, rate_radps
        second = 0.0 if last is None else (rate_radps - last) / self._dt_s
        phi = self._gains.c_r_per_s * (observation.yaw_rate_radps - rate_radps) - second
        share = self._share(DEMAND_FILTER_HZ)
        self._demand_radps2 += share * (phi - self._demand_radps2)
        self._curvature_demand_radps2 += share * (
            self._curvature_demand(observation, reference) - self._curvature_demand_radps2
        )
        self.reaching = Reaching(self._gains.u0_radps * authority_per_s, abs(self._demand_radps2))

    def _yaw_rate(self, measured_radps: float, speed_mps: float) -> float:
        """d psi / dt, rad/s: complementary filter of the measurement and the bicycle model."""
        if self._gains.yaw_rate_filter_hz == 0.0:
            return measured_radps
        slip = atan(self._vehicle.l_r_m / self._vehicle.wheelbase_m * tan(self.steering_rad))
        model = speed_mps * sin(slip) / self._vehicle.l_r_m
        predicted = self.yaw_rate_radps + model - self._model_radps
        share = self._share(self._gains.yaw_rate_filter_hz)
        self.yaw_rate_radps, self._model_radps = predicted + share * (measured_radps - predicted), model
        return self.yaw_rate_radps

    def _filtered_speed(self, measured_mps: float) -> float:
        """v, m/s: complementary filter of the measurement and the commanded acceleration.

        On a slippery road it lags by 1 / (2 pi f) times the missing acceleration.
        """
        if self._gains.speed_filter_hz == 0.0 or self.speed_mps is None:
            self.speed_mps = measured_mps
            return measured_mps
        predicted = max(self.speed_mps + self._acceleration_mps2 * self._dt_s, 0.0)
        self.speed_mps = predicted + self._share(self._gains.speed_filter_hz) * (measured_mps - predicted)
        return self.speed_mps

    def _speed(self, speed_mps: float, reference_mps: float) -> float:
        """v_d, limited by the reaching condition: the limit falls at once and rises slowly."""
        if not self._gains.slows_to_reach:
            return reference_mps
        self._reachable_mps = max(self._reachable_mps + RECOVERY_MPS2 * self._dt_s, speed_mps)
        if not self.reaching.holds:
            slower = speed_mps * self.reaching.authority_radps2 / self.reaching.demand_radps2
            self._reachable_mps = min(self._reachable_mps, max(slower, SLOWEST_MPS))
        return min(reference_mps, self._reachable_mps)

    def _share(self, cutoff_hz: float) -> float:
        """Weight of a new value in a first-order low-pass; 1 without one."""
        return 1.0 - exp(-2.0 * pi * cutoff_hz * self._dt_s) if cutoff_hz > 0.0 else 1.0

    def _reference_rate(self, reference: Reference) -> float:
        """d psi_d / dt, rad/s: as given, or differentiated and low-passed."""
        last, self._last_heading_rad = self._last_heading_rad, reference.heading_rad
        if reference.heading_rate_radps is not None:
            return reference.heading_rate_radps
        raw = 0.0 if last is None else wrap_angle(reference.heading_rad - last) / self._dt_s
        self._heading_rate_radps += self._share(self._gains.reference_filter_hz) * (raw - self._heading_rate_radps)
        return self._heading_rate_radps

    def _hard_braking_share(self, s_l: float, speed_mps: float) -> float:
        """Share of full braking, 0 to 1, for a large excess speed, as for an obstacle detected late."""
        if self._gains.hard_braking_error_mps == 0.0:
            return 0.0
        return min(max(s_l - hard_excess(speed_mps, self._gains.hard_braking_error_mps), 0.0), 1.0)

    def _accelerate(self, speed_mps: float, reference_mps: float, planned_mps2: float) -> float:
        """The acceleration, m/s^2, within the vehicle's limits."""
        s_l = self._gains.c_l * speed_mps - reference_mps
        demand = relay(-s_l, self._gains.speed_boundary_layer_mps)
        acceleration = demand * (self._gains.a0_mps2 if demand > 0.0 else self._gains.brake_a0_mps2)
        acceleration += planned_mps2
        hard_share = self._hard_braking_share(s_l, speed_mps)
        if self._change_limit is not None:
            if hard_share > 0.0:
                self._change_limit.reset()
            acceleration = self._change_limit.limit(acceleration)
        acceleration -= hard_share * (acceleration + self._vehicle.full_brake_mps2)
        return min(max(acceleration, -self._vehicle.full_brake_mps2), self._vehicle.full_throttle_mps2)


def _bounded(reference: Reference) -> Reference:
    """The reference within the input limits."""
    heading, speed, rate = reference.heading_rad, reference.speed_mps, reference.heading_rate_radps
    return Reference(
        heading if abs(heading) <= MAX_RAD else wrap_angle(heading),
        min(max(speed, -MAX_MPS), MAX_MPS),
        None if rate is None else min(max(rate, -MAX_RADPS), MAX_RADPS),
        min(max(reference.acceleration_mps2, -MAX_MPS2), MAX_MPS2),
    )
