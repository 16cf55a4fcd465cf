"""The sliding mode controller against bounds from theory."""

from dataclasses import replace
from math import hypot, pi, radians

import numpy as np
import pytest
from bicycle import Bicycle

from vpf_sim.configuration import build
from vpf_sim.controllers.gtsmc import Gains, Gtsmc, load_gains, relay
from vpf_sim.errors import InputError
from vpf_sim.seeding import stream
from vpf_sim.types import Reference, VehicleModel

CAR = VehicleModel()
LITERAL, PAPER, MOTION = (load_gains(name) for name in ("literal", "paper", "motion"))
FILTERED = replace(MOTION, yaw_rate_filter_hz=1.0)


def controller(gains: Gains, rate_hz: float = 60.0) -> Gtsmc:
    return Gtsmc(gains, CAR, rate_hz)


def test_the_manifold_is_reached_within_its_bound() -> None:
    """|s_r| falls at eta = u_0 v / L - c_r |psi_e'|max at least, so it is reached within |s_0| / eta."""
    car, control = Bicycle(), controller(replace(PAPER, u0_radps=1.5))
    reference = Reference(0.1, 5.55, 0.0)
    start = control.manifold(car.observe(), reference, 0.0)
    eta = 1.5 * car.speed_mps / CAR.wheelbase_m * 0.95 - 2.0 * abs(start)  # cos^2, and |psi_e'| <= |s_0|
    assert start == pytest.approx(-0.2)
    bound_steps = int(abs(start) / eta * 60.0) + 2
    for _ in range(bound_steps):
        car.step(control.command(car.observe(), reference))
    after = [abs(control.manifold(car.observe(), reference, 0.0))]
    for _ in range(60):
        car.step(control.command(car.observe(), reference))
        after.append(abs(control.manifold(car.observe(), reference, 0.0)))
    one_step = 2.0 * 1.5 * car.speed_mps / CAR.wheelbase_m / 60.0
    assert max(after) < 1.5 * one_step


def test_on_the_manifold_the_heading_error_decays_with_c_r() -> None:
    car, control = Bicycle(), controller(MOTION)
    reference = Reference(0.1, 5.55, 0.0)
    for _ in range(150):
        car.step(control.command(car.observe(), reference))
    assert car.yaw_rad == pytest.approx(0.1, abs=0.1 * np.exp(-0.6 * 3.5 * 2.5))


@pytest.mark.parametrize(("c_l", "speed"), [(0.8, 6.9375), (1.0, 5.55), (1.25, 4.44)])
def test_the_speed_settles_at_the_reference_over_c_l(c_l: float, speed: float) -> None:
    for gains in (PAPER, MOTION):
        car, control = Bicycle(), controller(replace(gains, c_l=c_l))
        for _ in range(600):
            car.step(control.command(car.observe(), Reference(0.0, 5.55, 0.0)))
        ripple = max(gains.a0_mps2, gains.brake_a0_mps2) / 60.0
        assert car.speed_mps == pytest.approx(speed, abs=ripple)


def test_the_heading_error_is_wrapped() -> None:
    control = controller(MOTION)
    car = Bicycle(yaw_rad=pi - 0.02)
    assert control.manifold(car.observe(), Reference(-pi + 0.02, 5.0), 0.0) == pytest.approx(-0.04 * 3.5)
    assert control.command(car.observe(), Reference(-pi + 0.02, 5.0, 0.0)).steering > 0.0  # right, the short way


def test_integrator_is_clamped_without_windup() -> None:
    control = controller(PAPER)
    car = Bicycle()
    for _ in range(600):
        command = control.command(car.observe(), Reference(1.5, 5.55, 0.0))
    assert command.steering == 1.0
    assert control.steering_rad == CAR.steering_limit_rad
    assert control.command(car.observe(), Reference(-1.5, 5.55, 0.0)).steering < 1.0


def test_at_standstill_the_steering_holds() -> None:
    control = controller(PAPER)
    control.command(Bicycle().observe(), Reference(0.5, 5.55, 0.0))
    held = control.steering_rad
    assert held > 0.0
    control.command(Bicycle(speed_mps=0.0).observe(), Reference(-0.5, 0.0, 0.0))
    assert control.steering_rad == held


def overshoot(gains: Gains, speed_mps: float) -> float:
    """Relative overshoot of a heading step within the layer."""
    car, control, most = Bicycle(speed_mps=speed_mps), controller(gains), 0.0
    while car.time_s < 10.0:
        car.step(control.command(car.observe(), Reference(0.004, speed_mps, 0.0)))
        most = max(most, car.yaw_rad / 0.004 - 1.0)
    return most


def test_damping_is_constant_at_low_speed() -> None:
    """exp(-pi z / sqrt(1 - z^2)) with the damping z = sqrt(k v / (4 c_r L))."""
    slope = MOTION.u0_radps / MOTION.boundary_layer_radps
    damping = np.sqrt(slope * 2.0 / (4.0 * MOTION.c_r_per_s * CAR.wheelbase_m))
    expected = np.exp(-pi * damping / np.sqrt(1.0 - damping**2))
    for speed_mps in (0.4, 1.0, 2.0):
        assert overshoot(MOTION, speed_mps) == pytest.approx(expected, abs=0.03)
    assert overshoot(replace(MOTION, layer_narrows_below_mps=0.0), 0.4) > 0.3


@pytest.mark.parametrize(("error_mps", "brake_mps2"), [(0.0, 0.0), (0.75, 3.0), (1.5, 6.0), (4.0, 6.0)])
def test_excess_speed_brakes_in_proportion_up_to_a0(error_mps: float, brake_mps2: float) -> None:
    command = controller(MOTION).command(Bicycle(speed_mps=5.0).observe(), Reference(0.0, 5.0 - error_mps, 0.0))
    assert -command.throttle * CAR.full_brake_mps2 == pytest.approx(brake_mps2)


def test_relay_is_sign_or_saturation() -> None:
    assert [relay(s, 0.0) for s in (-0.1, 0.0, 2.0)] == [-1.0, 0.0, 1.0]
    assert [relay(s, 0.5) for s in (-1.0, -0.25, 0.0, 0.25, 1.0)] == [-1.0, -0.5, 0.0, 0.5, 1.0]


def noisy_run(gains: Gains, seed: int = 3) -> tuple[float, float]:
    """(rms y m, rms steering rate rad/s) when the heading to y = 0 carries 1 deg of white noise."""
    random = stream(seed, "noise")
    car, control = Bicycle(y_m=0.0), controller(gains)
    places, rates = [], []
    for _ in range(1200):
        before = car.steering_rad
        psi_d = -0.16 * car.y_m + radians(1.0) * float(random.standard_normal())
        car.step(control.command(car.observe(), Reference(psi_d, 5.55)))
        places.append(car.y_m)
        rates.append(60.0 * (car.steering_rad - before))
    return hypot(*places) / len(places) ** 0.5, hypot(*rates) / len(rates) ** 0.5


def test_low_pass_suppresses_differentiated_noise() -> None:
    raw, _ = noisy_run(LITERAL)
    filtered, rate = noisy_run(PAPER)
    smooth, smooth_rate = noisy_run(replace(MOTION, c_r_per_s=2.5, u0_radps=0.65, boundary_layer_radps=0.13))
    assert raw > 3.0 * filtered
    assert filtered < 0.15
    assert smooth < 0.15
    assert smooth_rate < 0.6 * rate


def test_given_reference_rate_is_used_without_lag() -> None:
    """psi_d turns at 0.05 rad/s: with the rate given there is no lag, and without it s_r = 0 leaves rate / c_r."""

    def lag(rate: float) -> float:
        car, control = Bicycle(), controller(MOTION)
        for step in range(300):
            car.step(control.command(car.observe(), Reference(0.05 * step / 60.0, 5.55, rate)))
        return 0.05 * 299 / 60.0 - car.yaw_rad

    assert lag(0.05) == pytest.approx(0.0, abs=2e-3)
    assert lag(0.0) == pytest.approx(0.05 / 3.5, abs=2e-3)


def test_invalid_gains_are_rejected() -> None:
    table = {key: getattr(MOTION, key) for key in MOTION.__slots__}
    with pytest.raises(InputError, match=r"^gains\.toml: u0_radps: expected > 0, got 0\.0$"):
        build(Gains, {**table, "u0_radps": 0.0}, "gains.toml")


def steering_with_a_noisy_gyroscope(gains: Gains, bias: float = 0.0, noise: float = 0.01) -> tuple[float, float]:
    """(rms actuator rate rad/s, mean |y| m) while y = 0 is followed and the yaw rate is measured with errors."""
    random = stream(2, "gyroscope")
    car, control = Bicycle(y_m=0.2), controller(gains)
    rates, places = [], []
    for _ in range(900):
        seen = car.observe()
        measured = seen.yaw_rate_radps + bias + noise * float(random.standard_normal())
        before = car.steering_rad
        reference = Reference(-0.16 * car.y_m, 5.55, 0.0)
        car.step(control.command(replace(seen, yaw_rate_radps=measured), reference))
        rates.append(60.0 * (car.steering_rad - before))
        places.append(abs(car.y_m))
    return hypot(*rates[300:]) / 600**0.5, float(np.mean(places[300:]))


def test_gyroscope_noise_is_filtered_from_the_steering() -> None:
    rate, place = steering_with_a_noisy_gyroscope(FILTERED)
    raw_rate, _ = steering_with_a_noisy_gyroscope(MOTION)
    assert rate < 0.3 * raw_rate
    assert place < 0.02


def test_gyroscope_bias_shifts_the_car_by_the_closed_form() -> None:
    """s_r = 0 leaves psi_e = -bias / c_r, and y = psi_e / 0.16."""
    _, place = steering_with_a_noisy_gyroscope(FILTERED, bias=0.01, noise=0.0)
    assert place == pytest.approx(0.01 / 3.5 / 0.16, rel=0.1)


def test_exact_gyroscope_passes_the_filter_unchanged() -> None:
    """The model uses the present steering, so there is no lag."""
    car, control = Bicycle(), controller(FILTERED)
    for step in range(240):
        reference = Reference(0.3 * float(np.sin(step / 30.0)), 5.55, 0.6 * float(np.cos(step / 30.0)))
        seen = car.observe()
        car.step(control.command(seen, reference))
        assert control.yaw_rate_radps == pytest.approx(seen.yaw_rate_radps, abs=1e-9)
