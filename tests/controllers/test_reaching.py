"""The reaching condition of the sliding mode on roads with a fast-changing curvature."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from bicycle import Bicycle

from vpf_sim.controllers.gtsmc import Gains, Gtsmc, load_gains
from vpf_sim.driver_interface import Command
from vpf_sim.types import Reference, VehicleModel

CAR = VehicleModel()
# Less authority than the gains of `vpf`, so that it ends at a lower speed.
GENTLE = replace(load_gains("motion"), c_r_per_s=2.5, u0_radps=0.65, boundary_layer_radps=0.13)
LARGEST_PER_M, PERIOD_M = 0.05, 10.0  # of a curvature K sin(2 pi s / period)
CHANGE_PER_M2 = 2.0 * pi * LARGEST_PER_M / PERIOD_M  # k'
HOLDS_UP_TO_MPS = GENTLE.u0_radps / CAR.wheelbase_m / CHANGE_PER_M2  # u_0 v / L = k' v^2


def wave(gains: Gains, speed_mps: float, time_s: float = 12.0) -> tuple[list[float], list[float], list[bool]]:
    """Speeds, |s_r| and whether the condition held, of a car on the road at that reference speed."""
    car, control, way_m = Bicycle(speed_mps=speed_mps), Gtsmc(gains, CAR, 60.0), 0.0
    speeds, off, held = [], [], []
    for _ in range(round(60.0 * time_s)):
        phase = 2.0 * pi * way_m / PERIOD_M
        psi_d, rate = LARGEST_PER_M * PERIOD_M / (2.0 * pi) * (1.0 - cos(phase)), LARGEST_PER_M * sin(phase)
        reference = Reference(psi_d, speed_mps, rate * car.speed_mps)
        off.append(abs(control.manifold(car.observe(), reference, rate * car.speed_mps)))
        car.step(control.command(car.observe(), reference))
        held.append(control.reaching.holds)
        speeds.append(car.speed_mps)
        way_m += car.speed_mps / 60.0
    return speeds[240:], off[240:], held[240:]


def test_authority_and_demand_match_the_closed_form() -> None:
    """A curvature that grows at k' a metre: phi = -k' v^2, after the low-pass."""
    control, change = Gtsmc(GENTLE, CAR, 60.0), 0.01
    for step in range(120):
        rate = change * 5.55**2 * step / 60.0
        car = Bicycle(yaw_rad=0.0)
        car.yaw_rate_radps = rate
        control.command(car.observe(), Reference(0.0, 5.55, rate))
    assert control.reaching.authority_radps2 == pytest.approx(0.65 * 5.55 / 2.7)
    assert control.reaching.demand_radps2 == pytest.approx(change * 5.55**2, rel=0.01)
    assert control.reaching.holds


def test_speed_is_kept_while_the_reaching_condition_holds() -> None:
    assert 7.65 < HOLDS_UP_TO_MPS < 7.67
    speeds, off, held = wave(GENTLE, 0.75 * HOLDS_UP_TO_MPS)
    assert np.mean(held) > 0.98
    assert min(speeds) > 0.97 * 0.75 * HOLDS_UP_TO_MPS
    assert max(off) < 1.5 * GENTLE.boundary_layer_radps


def test_the_condition_fails_at_a_higher_speed() -> None:
    _, off, held = wave(GENTLE, 1.6 * HOLDS_UP_TO_MPS)
    assert np.mean(held) < 0.9
    assert max(off) > 3.0 * GENTLE.boundary_layer_radps


def test_reset_clears_what_was_commanded_before() -> None:
    """Nothing of the last episode carries over."""
    control, fresh, car = Gtsmc(GENTLE, CAR, 60.0), Gtsmc(GENTLE, CAR, 60.0), Bicycle(speed_mps=3.0)
    for step in range(60):
        control.command(car.observe(), Reference(0.0, 5.55, 0.6 * sin(2.0 * pi * step / 30.0)))
    assert not control.reaching.holds
    control.reset()
    for _ in range(3):
        assert control.command(car.observe(), Reference(0.0, 5.55, 0.0)) == fresh.command(
            car.observe(), Reference(0.0, 5.55, 0.0)
        )


def bend_error_deg(gains: Gains, speed_mps: float) -> float:
    """Largest heading error on a path with the fastest curvature change, by a steering rate of 0.45 rad/s.

    The curvature goes to 0.1 1/m and back.
    """
    car, control, worst = Bicycle(speed_mps=speed_mps), Gtsmc(gains, CAR, 60.0), 0.0
    curvature, psi_d, change = 0.0, 0.0, 0.45 / CAR.wheelbase_m / 60.0
    ramp = round(0.1 / change)
    for step in range(3 * ramp):
        curvature += change * (1.0, 0.0, -1.0)[step // ramp]
        psi_d += curvature * speed_mps / 60.0
        car.step(control.command(car.observe(), Reference(psi_d, speed_mps, curvature * speed_mps)))
        worst = max(worst, abs(np.degrees(car.yaw_rad - psi_d)))
    return worst


@pytest.mark.parametrize("speed_mps", [2.0, 3.5, 5.0])
def test_feedforward_follows_a_changing_curvature(speed_mps: float) -> None:
    """With feedforward no error in the layer is needed to turn the steering."""
    assert GENTLE.feedforward
    assert bend_error_deg(GENTLE, speed_mps) < 0.8
    assert bend_error_deg(replace(GENTLE, feedforward=False), speed_mps) > 1.5


@pytest.mark.parametrize(("speed_mps", "acceleration_mps2"), [(2.0, 1.5), (5.0, -2.5)])
def test_speed_changes_in_a_bend_need_no_feedforward(speed_mps: float, acceleration_mps2: float) -> None:
    """A bend of 0.1 1/m: the reference's rate changes, its curvature does not, so feedforward is zero."""

    def worst_deg(gains: Gains) -> float:
        car, control, psi_d, worst = Bicycle(speed_mps=speed_mps), Gtsmc(gains, CAR, 60.0), 0.0, 0.0
        for step in range(240):
            if step > 120:
                car.speed_mps += acceleration_mps2 / 60.0
                worst = max(worst, abs(np.degrees(car.yaw_rad - psi_d)))
            psi_d += 0.1 * car.speed_mps / 60.0
            steering = control.command(car.observe(), Reference(psi_d, car.speed_mps, 0.1 * car.speed_mps)).steering
            car.step(Command(0.0, steering))
        return worst

    assert worst_deg(GENTLE) < worst_deg(replace(GENTLE, feedforward=False)) + 0.05
