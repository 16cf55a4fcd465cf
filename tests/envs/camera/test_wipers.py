"""The wiper: motion, swept area and image of the blade."""

import numpy as np
import pytest

from vpf_sim.envs.camera.glass.pane import Pane
from vpf_sim.envs.camera.glass.wipers import RADII_M, SWEEP_RAD, Wiper, paint_blade
from vpf_sim.envs.camera.weather import FAST_WIPER_S, INTERVAL_WIPER_S, SLOW_WIPER_S
from vpf_sim.types import Camera

PANE = Pane.of(Camera())
CYCLE_S = 1.33


def wiper(period_s: float, seed: int = 0) -> Wiper:
    return Wiper(PANE, period_s, seed)


def turning_point(blade: Wiper) -> float:
    """A time at which the blade starts to rise."""
    times = np.arange(0.0, blade.period_s, 1e-3)
    angles = np.array([blade.angle(t) for t in times])
    rising = (angles < 1e-4) & (np.roll(angles, -1) > angles)
    return float(times[np.flatnonzero(rising)[0]])


@pytest.mark.parametrize("period_s", [FAST_WIPER_S, SLOW_WIPER_S, INTERVAL_WIPER_S])
def test_blade_angle_is_a_sine_followed_by_rest(period_s: float) -> None:
    blade = wiper(period_s)
    start, cycle_s = turning_point(blade), min(period_s, CYCLE_S)
    for share, angle in ((0.25, 0.5), (0.5, 1.0), (0.75, 0.5), (1.0, 0.0), (1.0 / 6.0, 0.25)):
        assert blade.angle(start + share * cycle_s) == pytest.approx(angle * SWEEP_RAD, abs=0.02)
    for t in np.linspace(start + cycle_s + 0.01, start + period_s - 0.01, 5):
        assert period_s <= cycle_s or blade.angle(float(t)) == 0.0
    assert blade.angle(start + 0.3) == pytest.approx(blade.angle(start + 0.3 + 7.0 * period_s))


@pytest.mark.parametrize(("period_s", "share"), [(FAST_WIPER_S, 0.2), (SLOW_WIPER_S, 0.2), (INTERVAL_WIPER_S, 0.07)])
def test_blade_is_visible_a_fifth_of_a_cycle(period_s: float, share: float) -> None:
    blade = wiper(period_s)
    present = [blade.blade(t) is not None for t in np.arange(0.0, 5.0 * period_s, 1.0 / 60.0)]
    assert np.mean(present) == pytest.approx(share, rel=0.25)


def test_one_pass_sweeps_exactly_the_reach_of_the_blade() -> None:
    blade = wiper(SLOW_WIPER_S)
    swath = blade.swath(0.0, SLOW_WIPER_S)
    assert swath is not None
    reached = (blade.radii_m >= RADII_M[0]) & (blade.radii_m <= RADII_M[1])
    np.testing.assert_array_equal(swath.mask > 0, reached)
    assert 0.9 < reached.mean() < 1.0  # a corner is out of its reach


def test_swath_lies_between_both_blade_angles() -> None:
    blade = wiper(SLOW_WIPER_S)
    start = turning_point(blade)
    early, late = start + 0.30, start + 0.36
    swath = blade.swath(early, late)
    assert swath is not None
    assert (swath.low, swath.high) == pytest.approx((blade.angle(early), blade.angle(late)))
    y, x = np.mgrid[0:240, 0:640]
    np.testing.assert_array_equal(swath.mask > 0, swath.holds(x.astype(float), 2.0 * y + 0.5))
    before, behind = (blade.blade(t) for t in (early, late))
    assert before is not None
    assert behind is not None
    for edge in (before, behind):  # the blade then and now lies along the swath's two sides
        assert 0.2 < (swath.mask[::2, ::4][edge > 200] > 0).mean() < 0.8


def test_swath_over_a_turning_point_reaches_up_to_it() -> None:
    blade = wiper(SLOW_WIPER_S)
    top = turning_point(blade) + SLOW_WIPER_S / 2.0
    swath = blade.swath(top - 0.3, top + 0.1)
    assert swath is not None
    assert swath.high == SWEEP_RAD
    assert swath.low == pytest.approx(blade.angle(top - 0.3))


def test_the_blade_is_a_soft_dark_band() -> None:
    blade = wiper(SLOW_WIPER_S)
    cover = blade.blade(turning_point(blade) + 0.33)
    assert cover is not None
    widths = 4 * (cover > 127).sum(axis=1)
    assert 20 < np.median(widths[widths > 0]) < 130  # px along the row, across a blade that leans
    steps = np.abs(np.diff(cover.astype(int), axis=1)).max()
    assert steps < 110  # of 255 in 4 px: no edge
    frame = np.full((480, 640, 3), 200, np.uint8)
    paint_blade(frame, cover)
    assert frame.min() < 50
    assert (frame == 200).mean() > 0.5


def test_seeds_shift_the_wiper_phase() -> None:
    assert wiper(4.0, 1).angle(0.7) == wiper(4.0, 1).angle(0.7)
    starts = {round(turning_point(wiper(4.0, seed)), 2) for seed in range(5)}
    assert len(starts) == 5


def test_blade_outside_the_image_changes_nothing() -> None:
    frame = np.full((480, 640, 3), 90, np.uint8)
    paint_blade(frame, np.zeros((120, 160), np.uint8))
    assert np.all(frame == 90)
