"""Falling drops against a simulated volume of rain, and against the geometry of their motion."""

from dataclasses import replace

import numpy as np
import pytest
from highway_scenes import add_ego, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.rain.streaks import Streaks, exposure_s_of
from vpf_sim.types import Camera, Floats, Image

CAMERA = Camera()
NEAREST_M = 0.6


def drops_per_m3_mm(rain_mmph: float, diameter_mm: Floats) -> Floats:
    """Marshall and Palmer 1948."""
    return np.asarray(8000.0 * np.exp(-4.1 * rain_mmph**-0.21 * diameter_mm))


def fall_speed_mps(diameter_mm: Floats) -> Floats:
    """Atlas, Srivastava and Sekhon 1973."""
    return np.asarray(np.maximum(9.65 - 10.3 * np.exp(-0.6 * diameter_mm), 0.1))


def streaks(rain_mmph: float = 50.0, seed: int = 1, gain: float = 1.0, exposure_s: float | None = None) -> Streaks:
    chosen = weather.load("HardRainNoon")
    atmosphere = replace(Atmosphere.of(chosen), rain_mmph=rain_mmph)
    return Streaks(CAMERA, atmosphere, Light.of(chosen), gain, seed, exposure_s)


def ahead(speed_mps: float, wind_mps: float = 0.0) -> tuple[float, float, float]:
    """The air relative to a camera that drives along the X axis; wind blows to the right."""
    return -speed_mps, wind_mps, 0.0


def darker_by(levels: float, source: Streaks) -> Image:
    """A frame darker than the drops by `levels` grey levels."""
    return np.full((CAMERA.height_px, CAMERA.width_px, 3), round(source.brightness - levels), np.uint8)


def counted(
    rain_mmph: float, speed_mps: float, exposure: float, contrast: float, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Levels and lengths of the drops of one frame, with every drop of a volume simulated."""
    edges = np.linspace(0.3, 6.0, 58)
    middle = 0.5 * (edges[1:] + edges[:-1])
    half_x, half_y = 1.0, 0.75
    far = np.maximum(1e-3 * CAMERA.fx_px * (middle + 0.1) * np.sqrt(0.25 * np.pi * contrast / 4.0), NEAREST_M)
    volume = far**3 / 3.0 * 4.0 * half_x * half_y  # farther away none reaches 4 grey levels, however slow
    number = rng.poisson(drops_per_m3_mm(rain_mmph, middle) * np.diff(edges) * volume)
    diameter = np.repeat(middle, number)
    z = np.repeat(far, number) * rng.random(len(diameter)) ** (1.0 / 3.0)
    z, diameter = z[z > NEAREST_M], diameter[z > NEAREST_M]
    x, y = rng.uniform(-half_x, half_x, len(z)), rng.uniform(-half_y, half_y, len(z))
    middle = np.stack([x * z, y * z, z])
    half = 0.5 * exposure * np.stack([0.0 * z, fall_speed_mps(diameter), -speed_mps + 0.0 * z])
    start, end = middle - half, middle + half
    length = CAMERA.fx_px * np.hypot(*(end[:2] / end[2] - start[:2] / start[2]))
    width = 1e-3 * CAMERA.fx_px * diameter / z
    return 0.25 * np.pi * width**2 / np.maximum(1.0, length) * contrast, length


@pytest.mark.parametrize(
    ("rain", "speed", "exposure"), [(50, 10, 0.002), (25, 10, 0.002), (50, 0, 0.002), (50, 20, 0.002)]
)
def test_drop_counts_and_lengths_match_a_simulated_volume(rain: float, speed: float, exposure: float) -> None:
    source = streaks(float(rain), exposure_s=exposure)
    frame = darker_by(100.0, source)
    rng = np.random.default_rng(0)
    level, length = (
        np.concatenate(a) for a in zip(*(counted(rain, speed, exposure, 100.0, rng) for _ in range(3)), strict=True)
    )
    drawn = [source.specks(frame, ahead(speed), float(k)) for k in range(6)]
    own_level = np.concatenate([specks.level for specks in drawn])
    own_length = np.concatenate([specks.length_px for specks in drawn])
    for least in (4.0, 8.0):
        assert (own_level >= least).sum() / 6.0 == pytest.approx((level >= least).sum() / 3.0, rel=0.1)
    assert np.median(own_length) == pytest.approx(np.median(length[level >= 4.0]), rel=0.1)
    assert np.percentile(own_length, 90) == pytest.approx(np.percentile(length[level >= 4.0], 90), rel=0.15)


def test_hard_rain_has_the_specks_of_the_table() -> None:
    source = streaks(50.0, exposure_s=0.002)
    specks = [source.specks(darker_by(100.0, source), ahead(10.0), float(k)) for k in range(4)]
    assert np.mean([len(s.level) for s in specks]) == pytest.approx(3810, rel=0.06)
    assert np.mean([(s.level >= 8.0).sum() for s in specks]) == pytest.approx(740, rel=0.1)


def test_drops_of_one_fall_speed_radiate_from_the_vanishing_point_of_the_rain() -> None:
    source = streaks(50.0)
    speed, wind = 15.0, 4.0
    specks = source.specks(darker_by(100.0, source), ahead(speed, wind))
    x, y = specks.x_px - CAMERA.cx_px + CAMERA.fx_px * wind / speed, specks.y_px - CAMERA.cy_px
    fall = speed * (specks.dy_px * x / specks.dx_px - y) / CAMERA.fy_px  # puts the vanishing point on the streak's line
    long = specks.length_px > 1.5
    assert long.sum() > 200
    assert np.all((fall[long] > 0.5) & (fall[long] < 9.65))
    assert np.median(fall[long]) == pytest.approx(6.5, abs=1.5)
    outward = specks.dx_px * x + specks.dy_px * (y + CAMERA.fy_px * fall / speed)
    assert np.all(outward[long] > 0.0)


def test_drops_are_invisible_before_the_sky_and_absent_when_dry() -> None:
    source = streaks(50.0)
    bright = darker_by(0.0, source)
    before = bright.copy()
    source.draw_drops(bright, ahead(10.0))
    assert np.array_equal(bright, before)
    road = straight_road()
    ego = add_ego(road, [20.0, 5.0])
    renderer = Renderer(road, Rig(noise_sd=0.0), weather.load("ClearNoon"), 1)
    assert np.array_equal(renderer.render(ego, 0.0), renderer.render(ego, 0.0))


def test_gain_brightens() -> None:
    levels = [streaks(50.0, gain=gain) for gain in (1.0, 3.0)]
    added = []
    for source in levels:
        frame = darker_by(60.0, source)
        before = frame.copy()
        source.draw_drops(frame, ahead(10.0))
        added.append(float((frame - before).sum()))
    assert added[1] == pytest.approx(3.0 * added[0], rel=0.1)


def test_seeds_have_their_own_drops_and_frames_differ() -> None:
    def frames(seed: int) -> list[Image]:
        source = streaks(50.0, seed)
        result = []
        for k in range(2):
            frame = darker_by(100.0, source)
            source.draw_drops(frame, ahead(10.0), k / 60.0)
            result.append(frame)
        return result

    (a, b), (again, _), (other, _) = frames(1), frames(1), frames(2)
    assert np.array_equal(a, again)
    assert not np.array_equal(a, b)
    assert not np.array_equal(a, other)


def test_added_light_matches_the_streaks() -> None:
    source = streaks(2.0)  # few that lie over each other
    frame = darker_by(100.0, source)
    before = frame.astype(float)
    specks = source.specks(frame, ahead(0.0))
    source.draw_drops(frame, ahead(0.0))
    points = 2.0 + np.floor(np.maximum(np.abs(specks.dx_px), np.abs(specks.dy_px)))
    expected = (specks.level * points / np.maximum(specks.width_px, 1.0)).sum()
    assert (frame[..., 0] - before[..., 0]).sum() == pytest.approx(float(expected), rel=0.1)
    assert np.array_equal(frame[..., 0], frame[..., 2])


def test_drops_of_a_moment_need_no_moment_before() -> None:
    def drawn(times: list[float]) -> Image:
        source = streaks(50.0)
        for time_s in times:
            frame = darker_by(100.0, source)
            source.draw_drops(frame, ahead(10.0 * time_s), time_s)
        return frame

    assert np.array_equal(drawn([0.5]), drawn([0.1, 7.0, 0.2, 0.3, 0.4, 0.5]))


def test_dim_light_lengthens_the_exposure() -> None:
    noon, sunset = (exposure_s_of(Light.of(weather.load(name))) for name in ("HardRainNoon", "HardRainSunset"))
    assert noon == pytest.approx(0.002)
    assert 2.0 * noon < sunset <= 0.008
