"""Haze against Koschmieder's law, on the rows of the ground."""

import numpy as np
import pytest

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.horizon import ground_top
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
    rows = np.arange(ground_top(camera), camera.height_px, dtype=float)
    place = ground_from_pixels(camera, np.stack([np.full_like(rows, camera.cx_px), rows], axis=-1))
    ahead = place[:, 0] - camera.forward_m
    depth = np.cos(camera.pitch_rad) * ahead + np.sin(camera.pitch_rad) * camera.height_m
    depth = np.minimum(depth, HILLS[-1][0])  # the line of trees ends the ground
    for colour in (0, 90, 255):
        found = np.full((len(rows), 3), float(colour))
        hazy = haze(name, camera).ground_rows().astype(float)
        found[: len(hazy)] = np.rint(found[: len(hazy)] * hazy[:, :1] / 255.0) + hazy[:, 1:]
        assert found == pytest.approx(hazed(name, colour, depth), abs=1.8)


def test_clear_haze_does_not_change_the_near_road() -> None:
    assert 5 < len(haze("ClearNoon").ground_rows()) < 60
