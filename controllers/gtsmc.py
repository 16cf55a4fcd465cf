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
road with the curvature rate k' phi is k' v^2, which grows faster with speed than the authority.
"""

from dataclasses import dataclass, replace
from math import atan, copysign, exp, pi, sin, tan
from typing import Literal

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.controllers.super_twisting import SuperTwisting
from vpf_sim.driver_interface import Command, Observation
from vpf_sim.errors import unknown_name
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Reference, VehicleModel

STANDSTILL_MPS = 0.1
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
    lateral_law: Literal["first_order", "super_twisting"] = setting(
        "Control law of the steering.", default="first_order"
    )
    disturbance_radps3: float = setting(
        "Largest rate D of the disturbance that the super-twisting law rejects.", default=0.0
    )
    layer_narrows_below_mps: float = setting(
        "Speed below which the layer of s_r narrows with the steering authority, against oscillation.",
        default=0.0,
        ge=0.0,
    )
    feedforward: bool = setting("Whether the bends of the reference are added to the steering rate.", default=False)

    def __post_init__(self) -> None:
        if (self.lateral_law == "super_twisting") != (self.disturbance_radps3 > 0.0):
            raise ValueError(
                f"disturbance_radps3: expected > 0 with super_twisting alone, got {self.disturbance_radps3}"
            )


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
        is_second_order = self._gains.lateral_law == "super_twisting"
        self._twisting = SuperTwisting(self._gains.disturbance_radps3, self._dt_s) if is_second_order else None

    def command(self, observation: Observation, reference: Reference) -> Command:
        """The command for one step of 1 / rate_hz."""
        reference = _bounded(reference)
        measured_radps = min(max(observation.yaw_rate_radps, -MAX_RADPS), MAX_RADPS)
        yaw_rate = self._yaw_rate(measured_radps, observation.speed_mps)
        steering = self._steer(replace(observation, yaw_rate_radps=yaw_rate), reference)
        acceleration = self._accelerate(observation.speed_mps, reference)
        return Command(
            acceleration / self._vehicle.full_mps2(acceleration), steering / self._vehicle.steering_limit_rad
        )

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

    def _accelerate(self, speed_mps: float, reference: Reference) -> float:
        """The acceleration, m/s^2, within the vehicle's limits."""
        demand = relay(reference.speed_mps - self._gains.c_l * speed_mps, self._gains.speed_boundary_layer_mps)
        acceleration = demand * (self._gains.a0_mps2 if demand > 0.0 else self._gains.brake_a0_mps2)
        acceleration += reference.acceleration_mps2
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
