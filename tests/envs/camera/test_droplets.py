"""Drops on the windscreen: impacts, merging, running, drying; time alone determines them."""

from math import cos, sin

import numpy as np
import pytest
from scipy.integrate import quad
from windscreen import BLADE_M, NO_RAIN, RAKE_RAD, area_m2, depth_m, glass, go, polar, px_per_mm, with_drops

from vpf_sim.envs.camera.glass import Drop, Glass
from vpf_sim.types import Floats

MEAN_LIFE_S, FOOTPRINT = 6.0, 1.83
SEEN_MM = 1.5  # spots of this size are drawn everywhere


def of_rain(rain_mmph: float, seed: int, speed_mps: float = 5.5) -> Glass:
    """A windscreen without a wiper in rain of some duration."""
    water = glass(droplets=100.0 * (rain_mmph / 50.0) ** 0.5, wiper_period_s=0.0, seed=seed)
    go(water, 0.0, speed_mps)
    return water


def marshall_palmer(power: float, speed_mps: float, rain_mmph: float, least_mm: float) -> float:
    """Impacts / (s m^2), weighted by diameter^power."""

    def of(d: float) -> float:
        fall = 9.65 - 10.3 * np.exp(-0.6 * d)
        closing = speed_mps * sin(RAKE_RAD) + fall * cos(RAKE_RAD)
        return float(d**power * 8000.0 * np.exp(-4.1 * rain_mmph**-0.21 * d) * closing)

    return float(quad(of, least_mm, 6.0)[0])


def volume(water: Glass) -> float:
    return sum(drop.size_mm**3 for drop in water.drops())


@pytest.mark.parametrize(("rain_mmph", "speed_mps"), [(1.0, 0.0), (1.0, 10.0), (3.0, 5.5)])
def test_impact_rate_and_sizes_match_marshall_and_palmer(rain_mmph: float, speed_mps: float) -> None:
    seeds = 12
    sizes = np.array([drop.size_mm for seed in range(seeds) for drop in of_rain(rain_mmph, seed, speed_mps).drops()])
    sizes = sizes[sizes > SEEN_MM]
    number = marshall_palmer(0.0, speed_mps, rain_mmph, SEEN_MM)
    expected = seeds * MEAN_LIFE_S * float(area_m2().sum()) * number
    assert len(sizes) == pytest.approx(expected, rel=0.05, abs=3.0 * expected**0.5)
    square = marshall_palmer(2.0, speed_mps, rain_mmph, SEEN_MM) / number
    assert np.mean(sizes**2) == pytest.approx(square, rel=0.1)


def test_drops_are_spread_evenly_over_the_glass() -> None:
    y = [drop.y_px for seed in range(20) for drop in of_rain(3.0, seed).drops() if drop.size_mm > SEEN_MM]
    counts = np.histogram(y, np.arange(0, 481, 80) - 0.5)[0]
    expected = area_m2().reshape(6, 80).sum(axis=1) / area_m2().sum() * len(y)
    assert np.all(np.abs(counts - expected) < 4.0 * expected**0.5)


@pytest.mark.parametrize("speed_mps", [0.0, 15.0])
def test_cover_grows_at_the_rate_of_the_spots_that_land(speed_mps: float) -> None:
    """Behind the blade, in the middle of the image."""
    covers = []
    for seed in range(8):
        water = glass(wiper_period_s=60.0, seed=seed)
        times = np.arange(0.0, 60.0, 0.05)
        wiped = float(times[np.argmax([water.blade_rad(float(t)) for t in times])]) + 0.7  # it lies again
        cover = []
        for seconds in (wiped, wiped + 0.3):
            go(water, seconds, speed_mps)
            cover.append(water.opacity()[60:420, 120:400].mean() / 255.0)
        covers.append(cover[1] - cover[0])
    spots = 1e-6 * np.pi / 4.0 * FOOTPRINT**2 * marshall_palmer(2.0, speed_mps, 50.0, 0.5)  # covered, 1/s
    assert np.mean(covers) == pytest.approx(0.3 * spots, rel=0.25)


def width_px(water: Glass) -> int:
    return int((water.opacity() > 127).any(axis=0).sum())


def test_drops_are_larger_at_the_top_of_the_windscreen() -> None:
    top, bottom = (width_px(with_drops(Drop(320.0, y, 4.0))) for y in (40.0, 440.0))
    assert top / bottom == pytest.approx(float(depth_m(np.array(440.0)) / depth_m(np.array(40.0))), rel=0.25)


def test_drop_width_matches_its_spot_on_the_windscreen() -> None:
    assert width_px(with_drops(Drop(320.0, 239.5, 3.0))) == pytest.approx(FOOTPRINT * 3.0 * px_per_mm(239.5), abs=2.5)


def column_below(y_px: float) -> list[Drop]:
    return [Drop(400.0 + aside, y_px + below, 0.9) for below in range(8, 80, 8) for aside in (-6.0, 0.0, 6.0)]


def test_a_running_drop_takes_up_what_it_touches_and_sheds_small_ones() -> None:
    """No water is lost."""
    beside = Drop(200.0, 140.0, 1.0)
    water = with_drops(Drop(400.0, 100.0, 5.0), beside, *column_below(100.0))
    before, shed = volume(water), []
    for tick in range(1, 41):
        go(water, tick * 0.05)
        shed += [drop.size_mm for drop in water.drops() if drop.size_mm not in (0.9, 1.0) and drop.size_mm < 3.0]
    assert volume(water) == pytest.approx(before, rel=1e-9)
    assert sum(drop.size_mm == 0.9 for drop in water.drops()) < 20
    assert beside in water.drops()
    assert shed
    assert 0.15 < min(shed) / 5.0 < max(shed) / 5.0 < 0.5


def test_drops_side_by_side_stay_apart() -> None:
    water = with_drops(Drop(300.0, 240.0, 2.0), Drop(310.0, 240.0, 1.0))  # the spot's radius is 5.8 px
    go(water, 1.0)
    assert len(water.drops()) == 2


@pytest.mark.parametrize(("speed_mps", "way"), [(0.0, 1), (11.0, 1), (16.0, 0), (25.0, -1)])
def test_large_drops_move_by_gravity_or_wind(speed_mps: float, way: int) -> None:
    small = Drop(200.0, 240.0, 1.0)
    water = with_drops(Drop(400.0, 240.0, 5.0), small)
    for tick in range(1, 31):
        go(water, tick * 0.05, speed_mps)
    large = max(water.drops(), key=lambda drop: drop.size_mm)
    assert np.sign(large.y_px - 240.0) == way
    assert way >= 0 or large.x_px > 400.0
    assert small in water.drops()


def test_drops_dry_off() -> None:
    left = Drop(100.0, 300.0, 0.8)
    water = with_drops(Drop(400.0, 100.0, 1.0, dies_s=2.0), left)
    go(water, 1.95)
    assert len(water.drops()) == 2
    go(water, 2.0)
    assert water.drops() == [left]


def test_opacity_shows_the_drops() -> None:
    water = of_rain(4.0, 3)
    drops = water.drops()
    assert len(drops) > 150
    again = with_drops(*drops)
    np.testing.assert_array_equal(again.opacity(), water.opacity())


def remaining(wiper_period_s: float, drops: list[Drop], until_s: float) -> list[Drop]:
    water = with_drops(*drops, wiper_period_s=wiper_period_s)
    go(water, until_s)
    return [drop for drop in drops if drop in water.drops()]


def test_one_pass_wipes_exactly_the_reach_of_the_blade() -> None:
    grid = [Drop(float(x), float(y), 1.0) for x in range(5, 640, 24) for y in range(5, 480, 24)]
    left = remaining(1.33, grid, 1.33)
    radius, _ = polar(np.array([drop.x_px for drop in grid]), np.array([drop.y_px for drop in grid]))
    out = (radius < BLADE_M[0]) | (radius > BLADE_M[1])
    assert left == [drop for drop, is_out in zip(grid, out.tolist(), strict=True) if is_out]
    assert 0.9 < 1.0 - out.mean() < 1.0


def test_a_drop_goes_when_the_blade_passes_it() -> None:
    drop = Drop(320.0, 240.0, 1.0)
    angle = float(polar(np.array(drop.x_px), np.array(drop.y_px))[1])
    water = with_drops(drop, wiper_period_s=4.0)
    gone = next(k for k in range(1, 600) if not covered_after(water, k / 120.0))
    angles = [water.blade_rad((gone + step) / 120.0) for step in (-1, 0)]
    assert min(angles) <= angle <= max(angles)


def covered_after(water: Glass, time_s: float) -> bool:
    go(water, time_s, gap_s=1.0 / 120.0)
    return bool(water.opacity()[240, 320] > 0)


def drawn_at(seconds: list[float], seed: int = 1) -> Floats:
    """The opacity at the last of these times, each at 5.5 m/s."""
    water = glass(seed=seed)
    for time_s in seconds:
        go(water, time_s)
    return water.opacity().astype(float)


def test_water_depends_on_the_time_alone_at_constant_speed() -> None:
    """A frame drawn alone, after others, or after skipped ones: always the same water."""
    alone = drawn_at([7.31])
    assert alone.max() > 0.0
    np.testing.assert_array_equal(drawn_at([k / 60.0 for k in range(30, 439)] + [7.31]), alone)
    np.testing.assert_array_equal(drawn_at([0.4, 7.31]), alone)
    np.testing.assert_array_equal(drawn_at([0.4, 30.0, 7.31]), alone)


def test_seed_determines_the_drops() -> None:
    np.testing.assert_array_equal(drawn_at([3.0], seed=1), drawn_at([3.0], seed=1))
    assert (drawn_at([3.0], seed=1) != drawn_at([3.0], seed=2)).mean() > 0.01


def test_almost_no_rain_is_almost_no_drops() -> None:
    assert not glass(droplets=NO_RAIN, wiper_period_s=0.0).drops()


def test_a_drop_needs_water_and_a_known_outline() -> None:
    with pytest.raises(ValueError, match="an index is out of its range"):
        with_drops(Drop(1.0, 1.0, 1.0, outline=4))
    with pytest.raises(ValueError, match="an index is out of its range"):
        glass(droplets=0.0).put(Drop(1.0, 1.0, 1.0))
