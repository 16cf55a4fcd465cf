"""Haze against Koschmieder's law, on colours and on the ground."""

import numpy as np
import pytest

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.sky.hills import HILLS
from vpf_sim.geometry import ground_from_pixels
from vpf_sim.types import Camera, Floats

CAMERAS = {"default": Camera(), "pitched": Camera(pitch_rad=0.06), "up": Camera(pitch_rad=-0.1, height_m=1.65)}


def haze(name: str, camera: Camera | None = None) -> Haze:
    of = weather.load(name)
    return Haze(camera or Camera(), Atmosphere.of(of), Light.of(of))


def hazed(name: str, colour: float, depth_m: Floats) -> Floats:
    """(..., 3) a hazed colour by Koschmieder's law."""
    of = weather.load(name)
    left = np.exp(-Atmosphere.of(of).extinction_per_m * depth_m)[..., None]
    return np.asarray(colour * left + Light.of(of).horizon * (1.0 - left))


def test_transmission_in_hard_rain_matches_the_literature() -> None:
    """Transmission in 50 mm/h, 0.312 R^0.67 per km; the fog of HardRainNoon takes a little more."""
    depths = np.array([10.0, 20.0, 40.0, 80.0, 200.0])
    assert haze("HardRainNoon").transmission(depths) == pytest.approx([0.958, 0.918, 0.842, 0.709, 0.424], rel=0.06)


def test_transmission_at_the_visibility_is_5_percent() -> None:
    visibility = Atmosphere.of(weather.load("FoggyNoon")).visibility_m
    assert visibility < 1000.0  # or it would not be called fog
    assert float(haze("FoggyNoon").transmission(np.array(visibility))) == pytest.approx(0.05, rel=0.01)


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
@pytest.mark.parametrize("name", ["FoggyNoon", "HardRainNoon", "ClearNoon"])
def test_ground_is_hazed_by_depth(name: str, camera: Camera) -> None:
    for colour in (0, 90, 255):
        frame = np.full((camera.height_px, camera.width_px, 3), colour, np.uint8)
        haze(name, camera).ground(frame)
        rows = np.arange(camera.height_px, dtype=float)
        place = ground_from_pixels(camera, np.stack([np.full_like(rows, camera.cx_px), rows], axis=-1))
        ahead = place[:, 0] - camera.forward_m
        depth = np.cos(camera.pitch_rad) * ahead + np.sin(camera.pitch_rad) * camera.height_m
        ground = np.isfinite(depth)
        depth = np.minimum(depth, HILLS[-1][0])  # the line of trees ends the ground
        assert frame[ground, 3] == pytest.approx(hazed(name, colour, depth[ground]), abs=1.8)
        assert np.all(frame[~ground] == colour)
        assert np.all(frame == frame[:, :1])


def test_clear_haze_does_not_change_the_near_road() -> None:
    rng = np.random.default_rng(0)
    frame = rng.integers(0, 256, (480, 640, 3), dtype=np.uint8)
    hazy = frame.copy()
    haze("ClearNoon").ground(hazy)
    assert np.array_equal(hazy[300:], frame[300:])
    assert not np.array_equal(hazy[240:245], frame[240:245])


def test_colours_are_hazed_by_depth() -> None:
    depths = np.array([5.0, 50.0, 500.0])
    got = haze("FoggyNoon").colours(np.full((3, 3), 40.0), depths)
    assert got == pytest.approx(hazed("FoggyNoon", 40.0, depths))
