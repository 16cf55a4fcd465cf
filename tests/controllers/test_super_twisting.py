"""The second-order sliding mode: closed-form plant, comparison with the relay, and in the controller."""

from dataclasses import replace
from math import cos, sin, sqrt

import numpy as np
import pytest
from bicycle import Bicycle
from scipy.linalg import solve_continuous_lyapunov

from vpf_sim.configuration import build
from vpf_sim.controllers.gtsmc import Gains, Gtsmc, load_gains
from vpf_sim.controllers.super_twisting import SuperTwisting
from vpf_sim.errors import InputError
from vpf_sim.types import Floats, Reference, VehicleModel

D, AUTHORITY, PLENTY = 2.0, 2.0, 1e3
CAR = VehicleModel()
TWISTING = load_gains("super-twisting")
RELAY = replace(TWISTING, lateral_law="first_order", disturbance_radps3=0.0)  # the printed sign function


def plant(law: SuperTwisting | None, s: float, rate: float, dt: float, time_s: float) -> Floats:
    """(n,) s of ds/dt = b u + (rate / 3) sin 3t, exact over each step; without a law the relay u = -sign(s)."""
    found = []
    for k in range(round(time_s / dt)):
        u = -np.sign(s) if law is None else law.rate(s, AUTHORITY, PLENTY)
        s += AUTHORITY * u * dt - rate / 9.0 * (cos(3.0 * (k + 1) * dt) - cos(3.0 * k * dt))
        found.append(s)
    return np.array(found)


@pytest.mark.parametrize("start", [0.05, 0.5, -2.0])
def test_manifold_is_reached_within_the_lyapunov_bound(start: float) -> None:
    """J. Moreno, M. Osorio, A Lyapunov approach to second-order sliding mode controllers and observers, CDC 2008.

    With x = (sqrt|s| sign s, w), x' = A x / sqrt|s|, A' P + P A = -Q and V = x' P x, s = w = 0 is reached within
    2 sqrt(V) / gamma, gamma = lambda_min(Q) sqrt(lambda_min(P)) / lambda_max(P).
    """
    dt = 1e-4
    law = SuperTwisting(D, dt)
    A, Q = np.array([[-0.5 * law.k1, 0.5], [-law.k2, 0.0]]), np.eye(2)
    P = solve_continuous_lyapunov(A.T, -Q)
    low, high = np.linalg.eigvalsh(P)
    bound_s = 2.0 * sqrt(P[0, 0] * abs(start)) * high / sqrt(low)
    s = plant(law, start, 0.0, dt, bound_s + 0.5)
    reached_s = dt * (1 + int(np.flatnonzero(np.abs(s) > 1e-6)[-1]))
    assert 0.2 * sqrt(abs(start)) < reached_s < bound_s
    assert abs(law.w_radps2) < 1e-3


def test_disturbance_below_its_rate_bound_is_fully_rejected() -> None:
    """The remaining s is dt phi, and smooth."""
    dt = 1e-3
    law = SuperTwisting(D, dt)
    s = plant(law, 0.3, 0.95 * D, dt, 8.0)
    phi = 0.95 * D / 3.0 * np.sin(3.0 * dt * np.arange(len(s)))
    assert s[4000:] == pytest.approx(dt * phi[4000:], abs=5e-6)
    assert law.w_radps2 == pytest.approx(-phi[-1], abs=0.01)


def test_disturbance_above_its_rate_bound_is_not_rejected() -> None:
    s = plant(SuperTwisting(0.2 * D, 1e-3), 0.0, 0.95 * D, 1e-3, 8.0)
    assert np.abs(s[4000:]).max() > 0.01


def test_super_twisting_is_closer_and_smoother_than_the_relay() -> None:
    dt = 1.0 / 60.0
    smooth, relay = (plant(law, 0.1, 0.95 * D, dt, 6.0)[180:] for law in (SuperTwisting(D, dt), None))
    assert np.abs(smooth).max() < 0.5 * np.abs(relay).max()
    assert np.abs(np.diff(smooth)).max() < 0.05 * np.abs(np.diff(relay)).max()


def test_saturated_rate_does_not_wind_up() -> None:
    law = SuperTwisting(D, 1.0 / 60.0)
    rates = [law.rate(5.0, AUTHORITY, 0.65) for _ in range(600)]
    assert rates == [-0.65] * 600
    assert abs(law.w_radps2) <= AUTHORITY * 0.65
    comes_back = [law.rate(-0.2, AUTHORITY, 0.65) for _ in range(60)]
    assert comes_back[-1] > 0.0


def swerve(gains: Gains) -> tuple[float, float, float]:
    """(largest |s_r|, rms of the actuator's rate, its reversals per second) for an oscillating heading."""
    car, control = Bicycle(), Gtsmc(gains, CAR, 60.0)
    sizes, angles = [], []
    for step in range(360):
        time_s = step / 60.0
        psi_d = Reference(0.2 * sin(1.5 * time_s), 5.55, 0.3 * cos(1.5 * time_s))
        sizes.append(abs(control.manifold(car.observe(), psi_d, 0.3 * cos(1.5 * time_s))))
        car.step(control.command(car.observe(), psi_d))
        angles.append(car.steering_rad)
    moves = np.diff(angles)[60:]
    turns = np.count_nonzero(np.diff(np.sign(moves)))
    return max(sizes[60:]), 60.0 * float(np.sqrt(np.mean(moves**2))), turns / 5.0


def test_super_twisting_tracks_without_chattering() -> None:
    off, rate, turns = swerve(TWISTING)
    relay_off, relay_rate, relay_turns = swerve(RELAY)
    assert off < 0.02
    assert relay_off < 0.1
    assert (relay_rate, relay_turns) > (0.6, 20.0)
    assert rate < 0.5 * relay_rate
    assert turns < 0.1 * relay_turns


@pytest.mark.parametrize(("law", "rate", "got"), [("first_order", 2.0, "2.0"), ("super_twisting", 0.0, "0.0")])
def test_disturbance_bound_requires_super_twisting(law: str, rate: float, got: str) -> None:
    table = {key: getattr(TWISTING, key) for key in TWISTING.__slots__}
    table |= {"lateral_law": law, "disturbance_radps3": rate}
    with pytest.raises(InputError, match=f"disturbance_radps3: expected > 0 with super_twisting alone, got {got}"):
        build(Gains, table, "gains.toml")
