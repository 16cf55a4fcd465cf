"""Noise, exposure and blur of the image sensor."""

from itertools import pairwise

import numpy as np
import pytest

from vpf_sim.envs.camera import Rig, weather
from vpf_sim.envs.camera.sensor import Sensor, noise_of
from vpf_sim.errors import InputError
from vpf_sim.types import Camera, Floats, Image

CAMERA = Camera()


def exposed(picture: Image, rig: Rig, name: str = "clear", frames: int = 1, seed: int = 1) -> list[Floats]:
    sensor = Sensor(rig, weather.load(name), seed)
    result = []
    for k in range(frames):
        frame = picture.copy()
        sensor.expose(frame, k / 60.0)
        result.append(frame.astype(float))
    return result


def grey(level: int) -> Image:
    return np.full((CAMERA.height_px, CAMERA.width_px, 3), level, np.uint8)


@pytest.mark.parametrize(("name", "sd"), [("ClearNoon", 1.3), ("HardRainNoon", 2.5), ("ClearSunset", 2.5)])
def test_the_weathers_light_sets_the_noise(name: str, sd: float) -> None:
    assert noise_of(weather.load(name)) == pytest.approx(sd)
    frame = exposed(grey(120), Rig(CAMERA), name)[0]
    assert frame.mean() == pytest.approx(120.0, abs=0.05)
    assert frame.std() == pytest.approx(np.hypot(sd, np.sqrt(1 / 12)), rel=0.05)  # and that of rounding


def test_rig_noise_overrides_the_weather() -> None:
    frame = exposed(grey(120), Rig(CAMERA, noise_sd=4.0), "ClearNoon")[0]
    assert frame.std() == pytest.approx(4.0, rel=0.05)
    assert np.array_equal(exposed(grey(120), Rig(CAMERA, noise_sd=0.0), "HardRainNoon")[0], grey(120))


def test_noise_is_new_in_every_frame_and_strip() -> None:
    frames = [frame - 120.0 for frame in exposed(grey(120), Rig(CAMERA, noise_sd=2.0), frames=4)]
    for earlier, later in pairwise(frames):
        assert abs(np.corrcoef(earlier.ravel(), later.ravel())[0, 1]) < 0.02
    strips = [frames[0][top : top + 120].ravel() for top in range(0, 480, 120)]
    assert np.abs(np.corrcoef(strips) - np.eye(4)).max() < 0.02


def test_noise_is_softened_by_colour_interpolation() -> None:
    noise = exposed(grey(120), Rig(CAMERA, noise_sd=3.0))[0] - 120.0
    beside = np.mean(noise[:, 1:] * noise[:, :-1]) / noise.var()
    farther = np.mean(noise[:, 3:] * noise[:, :-3]) / noise.var()
    assert 0.1 < beside < 0.4
    assert abs(farther) < 0.02


def test_seeds_have_noise_of_their_own_and_repeat_it() -> None:
    one, again, other = (exposed(grey(120), Rig(CAMERA, noise_sd=2.0), seed=seed)[0] for seed in (1, 1, 2))
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)


def test_exposure_of_one_stop_doubles_the_light() -> None:
    """In linear light, before the gamma of 2.2; clipped at white."""
    for ev in (-1.0, 1.0, 2.0):
        got = exposed(grey(80), Rig(CAMERA, noise_sd=0.0, exposure_ev=ev))[0]
        assert np.all(np.abs((got / 80.0) ** 2.2 - 2.0**ev) < 0.02 * 2.0**ev)
    assert np.all(exposed(grey(200), Rig(CAMERA, noise_sd=0.0, exposure_ev=2.0))[0] == 255)


@pytest.mark.parametrize("blur_px", [0.5, 1.0, 2.5])
def test_blur_spreads_a_point_by_its_standard_deviation_and_moves_nothing(blur_px: float) -> None:
    picture = grey(0)
    picture[100:103, 200:203] = 240
    got = exposed(picture, Rig(CAMERA, noise_sd=0.0, blur_px=blur_px))[0][80:123, 180:223, 0]
    x = np.arange(43) - 21.0
    share = got / got.sum()
    assert np.abs([(share * x).sum(), (share * x[:, None]).sum()]).max() < 0.01
    assert (share * x**2).sum() == pytest.approx(2.0 / 3.0 + blur_px**2, rel=0.1)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"noise_sd": -1.0}, "noise_sd: expected 0 to 20 grey levels, got -1.0"),
        ({"exposure_ev": 5.0}, "exposure_ev: expected -4 to 4, got 5.0"),
        ({"blur_px": float("nan")}, "blur_px: expected a finite number, got nan"),
    ],
)
def test_impossible_sensor_settings_are_rejected(options: dict[str, float], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Rig(CAMERA, **options)
