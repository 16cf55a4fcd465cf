"""Drops on the windscreen: impact rate, merging, running, drying; the planes match the drop list."""

import numpy as np
import pytest
from scipy.integrate import quad

from vpf_sim.envs.camera.glass.droplets import Droplets
from vpf_sim.envs.camera.glass.drops import DROP
from vpf_sim.envs.camera.glass.impacts import FOOTPRINT, Impacts
from vpf_sim.envs.camera.glass.pane import RAKE_RAD, Pane
from vpf_sim.envs.camera.glass.planes import Planes
from vpf_sim.envs.camera.glass.wipers import Wiper
from vpf_sim.types import Camera

CAMERA = Camera()
PANE = Pane.of(CAMERA)
TICK_S = 1 / 30
NO_RAIN = 0.0


def droplets(rain_mmph: float = 50.0, seed: int = 0) -> Droplets:
    return Droplets(PANE, Planes(CAMERA), rain_mmph, seed)


def drops(*places: tuple[float, float, float]) -> np.ndarray:
    """At rest: x px, y px, diameter mm."""
    made = np.zeros(len(places), DROP)
    made["x"], made["y"], made["size"] = np.array(places).T
    made["dies"] = 1e9
    return made


def placed(*places: tuple[float, float, float]) -> Droplets:
    glass = droplets(NO_RAIN)
    made = drops(*places)
    glass.picture.shape(made)
    glass.add(made)
    return glass


def assert_drawn_as_listed(glass: Droplets) -> None:
    fresh = droplets(NO_RAIN)
    fresh.add(glass.drops)
    np.testing.assert_array_equal(glass.planes.alpha, fresh.planes.alpha)


def marshall_palmer(power: float, speed_mps: float, rain_mmph: float) -> float:
    """Impacts / (s m^2), weighted by diameter^power, from 0.5 to 6 mm."""

    def of(d: float) -> float:
        fall = 9.65 - 10.3 * np.exp(-0.6 * d)
        closing = speed_mps * np.sin(RAKE_RAD) + fall * np.cos(RAKE_RAD)
        return d**power * 8000.0 * np.exp(-4.1 * rain_mmph**-0.21 * d) * closing

    return quad(of, 0.5, 6.0)[0]


@pytest.mark.parametrize(("rain_mmph", "speed_mps"), [(5.0, 10.0), (50.0, 0.0), (50.0, 25.0)])
def test_impact_rate_matches_marshall_and_palmer(rain_mmph: float, speed_mps: float) -> None:
    impacts = Impacts(rain_mmph)
    diameters = impacts.draw(np.random.default_rng(1), speed_mps, area_time=4.0)
    expected = 4.0 * marshall_palmer(0.0, speed_mps, rain_mmph)
    assert len(diameters) == pytest.approx(expected, rel=0.01, abs=4.0 * expected**0.5)
    assert np.mean(diameters**2) == pytest.approx(4.0 * marshall_palmer(2.0, speed_mps, rain_mmph) / expected, rel=0.05)


@pytest.mark.parametrize("speed_mps", [0.0, 5.5, 15.0])
def test_cover_grows_at_the_rate_of_the_spots_that_land(speed_mps: float) -> None:
    seconds, seeds = 0.3, 6
    cover = 0.0
    for seed in range(seeds):
        glass = droplets(seed=seed)
        for tick in range(1, 10):
            glass.advance(tick * TICK_S, TICK_S, speed_mps)
        cover += glass.planes.alpha.mean() / 255.0 / seeds
    share_of_glass = 1e-6 * np.pi / 4.0 * FOOTPRINT**2 * marshall_palmer(2.0, speed_mps, 50.0)  # covered, 1/s
    assert cover == pytest.approx(seconds * share_of_glass, rel=0.2)


def test_drops_are_spread_evenly_over_the_glass() -> None:
    y = PANE.spread(np.random.default_rng(0).random(200_000))
    counts = np.histogram(y, np.arange(0, 481, 40) - 0.5)[0]
    # a px at depth z sees glass of z^3 / (f^2 z0 sin r) m^2: z / f across, z^2 / (f z0 sin r) along
    z = 0.1 / (1.0 - (np.arange(480) - 239.5) / 320.0 / np.tan(RAKE_RAD))
    expected = (z**3).reshape(12, 40).sum(axis=1) / (z**3).sum()
    np.testing.assert_allclose(counts / len(y), expected, rtol=0.05)


def test_drops_are_larger_at_the_top_of_the_windscreen() -> None:
    top, bottom = placed((320.0, 40.0, 2.0)), placed((320.0, 440.0, 2.0))
    widths = [(glass.planes.alpha > 127).any(axis=0).sum() for glass in (top, bottom)]
    assert 2.0 < widths[0] / widths[1] < 4.0


def test_drop_width_matches_its_spot_on_the_windscreen() -> None:
    opaque = placed((320.0, 239.5, 3.0)).planes.alpha > 127
    assert opaque.any(axis=0).sum() == pytest.approx(1.83 * 3.0 * 320.0 / 100.0, abs=2.5)  # f D / z


def test_touching_drops_merge_at_their_centre_of_mass() -> None:
    glass = placed((300.0, 240.0, 2.0), (302.0, 242.0, 1.0), (500.0, 240.0, 1.5))
    glass.picture.put(glass.merge(np.array([1]), len(glass.drops)))
    merged, apart = sorted(glass.drops, key=lambda drop: drop["x"])
    assert merged["size"] ** 3 == pytest.approx(2.0**3 + 1.0**3)
    assert (merged["x"], merged["y"]) == pytest.approx((300.0 + 2.0 / 9.0, 240.0 + 2.0 / 9.0))
    assert (apart["x"], apart["size"]) == (500.0, 1.5)
    assert_drawn_as_listed(glass)


def test_drops_side_by_side_stay_apart() -> None:
    glass = placed((300.0, 240.0, 2.0), (310.0, 240.0, 1.0))  # the spot's radius is 5.8 px
    glass.merge(np.array([0, 1]), len(glass.drops))
    assert len(glass.drops) == 2


@pytest.mark.parametrize(("speed_mps", "way"), [(0.0, 1), (11.0, 1), (16.0, 0), (25.0, -1)])
def test_large_drops_move_by_gravity_or_wind(speed_mps: float, way: int) -> None:
    glass = placed((400.0, 240.0, 5.0), (200.0, 240.0, 1.0))
    for tick in range(1, 16):
        glass.advance(tick * TICK_S, TICK_S, speed_mps)
    large, small = glass.drops[np.argmax(glass.drops["size"])], glass.drops[glass.drops["x"] == 200.0][0]
    assert np.sign(large["y"] - 240.0) == way
    assert way >= 0 or large["x"] > 400.0
    assert small["y"] == 240.0
    assert_drawn_as_listed(glass)


def test_running_drop_sheds_drops_and_conserves_water() -> None:
    glass = placed((400.0, 100.0, 6.0))
    for tick in range(1, 61):
        glass.advance(tick * TICK_S, TICK_S, 5.5)
    assert len(glass.drops) > 2
    assert (glass.drops["size"] ** 3).sum() == pytest.approx(6.0**3)
    assert_drawn_as_listed(glass)


def test_drops_dry_off() -> None:
    glass = placed((400.0, 100.0, 1.0), (100.0, 300.0, 0.8))
    glass.drops["dies"][0] = 5.0
    glass.advance(5.0, TICK_S, 5.5)
    assert glass.drops["x"].tolist() == [100.0]
    assert_drawn_as_listed(glass)


def test_planes_match_the_drop_list_after_any_history() -> None:
    glass = droplets(100.0, seed=3)
    swath = Wiper(PANE, 1.33, 0).swath(0.0, 1.33)
    assert swath is not None
    for tick in range(1, 46):
        glass.advance(tick * 0.1, 0.1, 8.0)
        if tick % 20 == 0:
            glass.wipe(swath)
    assert len(glass.drops) > 200
    assert_drawn_as_listed(glass)


def test_seed_determines_the_drops() -> None:
    first, again, other = (droplets(seed=seed) for seed in (1, 1, 2))
    for glass in (first, again, other):
        for tick in range(1, 31):
            glass.advance(tick * TICK_S, TICK_S, 5.5)
    np.testing.assert_array_equal(first.planes.source, again.planes.source)
    np.testing.assert_array_equal(first.drops, again.drops)
    assert (first.planes.alpha != other.planes.alpha).mean() > 0.05
