"""The gradient-tracking sliding mode controller (GTSMC): it turns the car along the field's gradient line.

Lateral, with psi_e = psi - psi_d, the steering actuator as an integrator:

    s_r = c_r psi_e + d psi_e / dt,    d delta / dt = u = -u_0 sign(s_r),    |delta| <= delta_0.

Longitudinal: s_l = c_l v - v_d, a = -a_0 sign(s_l). With a boundary layer, sign(s) becomes clip(s / layer, -1, 1).

Since d s_r / dt = (v / L) u + (what the reference does), the manifold is reached only while u_0 v / L exceeds the
latter, and at standstill the steering has no authority at all: there it is held.
"""

from dataclasses import dataclass
from math import copysign, exp, pi

from vpf_sim import tables
from vpf_sim.errors import unknown_name
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Command, Observation, Reference, VehicleModel

STANDSTILL_MPS = 0.1


@dataclass(frozen=True, slots=True)
class Gains:
    """One set of gains; units are in the names."""

    c_r_per_s: float  # c_r
    u0_radps: float  # u_0
    boundary_layer_radps: float  # of s_r; 0 is the printed sign function
    reference_filter_hz: float  # low-pass of the differentiated reference; 0 is none
    c_l: float
    a0_mps2: float  # a_0 when speeding up
    brake_a0_mps2: float  # a_0 when slowing down
    speed_boundary_mps: float  # of s_l; 0 is the printed sign function

    def __post_init__(self) -> None:
        for key in ("c_r_per_s", "u0_radps", "c_l", "a0_mps2", "brake_a0_mps2"):
            if not getattr(self, key) > 0.0:
                raise ValueError(f"{key}: expected > 0, got {getattr(self, key)}")
        for key in ("boundary_layer_radps", "reference_filter_hz", "speed_boundary_mps"):
            if not getattr(self, key) >= 0.0:
                raise ValueError(f"{key}: expected >= 0, got {getattr(self, key)}")


def load_gains(name: str) -> Gains:
    """The set [gtsmc.`name`] of gains.toml."""
    sets = tables.read("vpf_sim.controllers", "gains.toml")["gtsmc"]
    if name not in sets:
        raise unknown_name("gains", name, sets)
    return tables.build(Gains, sets[name], f"gains.toml: [gtsmc.{name}]")


def relay(s: float, layer: float) -> float:
    """sign(s), or its saturation in a boundary layer of that half width; 0 at 0."""
    if layer > 0.0:
        return max(-1.0, min(1.0, s / layer))
    return copysign(1.0, s) if s else 0.0


class Gtsmc:
    """The controller with its actuator's angle and the memory of its reference."""

    def __init__(self, gains: Gains, vehicle: VehicleModel, rate_hz: float) -> None:
        self._gains = gains
        self._vehicle = vehicle
        self._dt_s = 1.0 / rate_hz
        self.reset()

    def reset(self) -> None:
        """Wheels straight, no memory."""
        self.steering_rad = 0.0
        self._last_heading_rad: float | None = None
        self._heading_rate_radps = 0.0

    def command(self, observation: Observation, reference: Reference) -> Command:
        """One step of 1 / rate_hz."""
        steering = self._steer(observation, reference)
        throttle = self._accelerate(observation.speed_mps, reference.speed_mps)
        return Command(throttle, steering / self._vehicle.steering_limit_rad)

    def manifold(self, observation: Observation, reference: Reference, heading_rate_radps: float) -> float:
        """s_r, rad/s."""
        error = wrap_angle(observation.yaw_rad - reference.heading_rad)
        return self._gains.c_r_per_s * error + observation.yaw_rate_radps - heading_rate_radps

    def _steer(self, observation: Observation, reference: Reference) -> float:
        """The angle of the actuator after one step, rad; clamping the integrator itself is its anti-windup."""
        rate = self._reference_rate(reference)
        if observation.speed_mps > STANDSTILL_MPS:
            s_r = self.manifold(observation, reference, rate)
            step = -self._gains.u0_radps * relay(s_r, self._gains.boundary_layer_radps) * self._dt_s
            limit = self._vehicle.steering_limit_rad
            self.steering_rad = max(-limit, min(limit, self.steering_rad + step))
        return self.steering_rad

    def _reference_rate(self, reference: Reference) -> float:
        """d psi_d / dt: as given, or differentiated and low-passed."""
        last, self._last_heading_rad = self._last_heading_rad, reference.heading_rad
        if reference.heading_rate_radps is not None:
            return reference.heading_rate_radps
        raw = 0.0 if last is None else wrap_angle(reference.heading_rad - last) / self._dt_s
        cutoff = self._gains.reference_filter_hz
        share = 1.0 - exp(-2.0 * pi * cutoff * self._dt_s) if cutoff > 0.0 else 1.0
        self._heading_rate_radps += share * (raw - self._heading_rate_radps)
        return self._heading_rate_radps

    def _accelerate(self, speed_mps: float, reference_mps: float) -> float:
        """Normalised throttle (> 0) or brake (< 0)."""
        s_l = self._gains.c_l * speed_mps - reference_mps
        wish = relay(-s_l, self._gains.speed_boundary_mps)
        if wish > 0.0:
            return min(1.0, wish * self._gains.a0_mps2 / self._vehicle.full_throttle_mps2)
        return max(-1.0, wish * self._gains.brake_a0_mps2 / self._vehicle.full_brake_mps2)
