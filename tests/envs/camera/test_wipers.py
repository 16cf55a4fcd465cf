"""The wiper: motion and image of the blade; what it wipes is in test_droplets.py."""

import numpy as np
import pytest
from windscreen import BLADE_M, draw, glass, polar

from vpf_sim.envs.camera.glass import Glass
from vpf_sim.envs.camera.weather import FAST_WIPER_S, INTERVAL_WIPER_S, SLOW_WIPER_S
from vpf_sim.types import Image

CYCLE_S, SWEEP_RAD = 1.33, np.pi / 2
GREY = 200


def wiper(period_s: float, seed: int = 0) -> Glass:
    return glass(droplets=0.0, wiper_period_s=period_s, seed=seed)


def turning_point(blade: Glass, period_s: float) -> float:
    """A time at which the blade starts to rise."""
    times = np.arange(0.0, period_s, 1e-3)
    angles = np.array([blade.blade_rad(t) for t in times])
    rising = (angles < 1e-4) & (np.roll(angles, -1) > angles)
    return float(times[np.flatnonzero(rising)[0]])


def cover(blade: Glass, k: int) -> Image:
    """Where the blade darkens frame k, 0..255."""
    frame = draw(blade, np.full((480, 640, 3), GREY, np.uint8), k)
    return np.asarray((GREY - frame[..., 0]) * (255.0 / (GREY - 22)), np.uint8)


@pytest.mark.parametrize("period_s", [FAST_WIPER_S, SLOW_WIPER_S, INTERVAL_WIPER_S])
def test_blade_angle_is_a_sine_followed_by_rest(period_s: float) -> None:
    blade = wiper(period_s)
    start, cycle_s = turning_point(blade, period_s), min(period_s, CYCLE_S)
    for share, angle in ((0.25, 0.5), (0.5, 1.0), (0.75, 0.5), (1.0, 0.0), (1.0 / 6.0, 0.25)):
        assert blade.blade_rad(start + share * cycle_s) == pytest.approx(angle * SWEEP_RAD, abs=0.02)
    for t in np.linspace(start + cycle_s + 0.01, start + period_s - 0.01, 5):
        assert period_s <= cycle_s or blade.blade_rad(float(t)) == 0.0
    assert blade.blade_rad(start + 0.3) == pytest.approx(blade.blade_rad(start + 0.3 + 7.0 * period_s), abs=1e-4)


@pytest.mark.parametrize(("period_s", "share"), [(FAST_WIPER_S, 0.2), (SLOW_WIPER_S, 0.2), (INTERVAL_WIPER_S, 0.07)])
def test_blade_is_visible_a_fifth_of_a_cycle(period_s: float, share: float) -> None:
    blade = wiper(period_s)
    present = [cover(blade, k).any() for k in range(0, int(5.0 * period_s * 60.0), 2)]
    assert np.mean(present) == pytest.approx(share, rel=0.3)


def test_the_blade_lies_along_its_angle() -> None:
    blade, y, x = wiper(SLOW_WIPER_S), *np.mgrid[0:480, 0:640].astype(float)
    radius, angle = polar(x, y)
    frames = 0
    for k in range(80):
        dark = cover(blade, k) > 200
        if dark.sum() < 2000:
            continue
        frames += 1
        across_m = radius[dark] * (angle[dark] - blade.blade_rad(k / 60.0))
        assert abs(np.median(across_m)) < 0.001
        assert np.abs(across_m).max() < 0.012
        assert BLADE_M[0] - 0.005 < radius[dark].min() < radius[dark].max() < BLADE_M[1] + 0.005
    assert frames > 5


def test_the_blade_is_a_soft_dark_band() -> None:
    blade = wiper(SLOW_WIPER_S)
    dark = cover(blade, round(60.0 * (turning_point(blade, SLOW_WIPER_S) + 0.33)))
    widths = (dark > 127).sum(axis=1)
    assert 20 < np.median(widths[widths > 0]) < 130  # px along the row, across a blade that leans
    steps = np.abs(np.diff(dark.astype(int), axis=1)).max()
    assert steps < 28  # of 255 in a px: no edge
    assert dark.max() > 220
    assert (dark == 0).mean() > 0.5


def test_seeds_shift_the_wiper_phase() -> None:
    assert wiper(4.0, 1).blade_rad(0.7) == wiper(4.0, 1).blade_rad(0.7)
    starts = {round(turning_point(wiper(4.0, seed), 4.0), 2) for seed in range(5)}
    assert len(starts) == 5
