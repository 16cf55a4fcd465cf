"""Frames of a standing camera are equal in still weather; rain changes them and does not repeat."""

import numpy as np
import pytest
import rain_layer

from vpf_sim.envs.camera import weather as weathers

HARD = weathers.load("HardRainNoon")
FALLING = HARD.model_copy(update={"droplets": 0.0, "wiper_period_s": 0.0})


def test_a_repeated_layer_is_found() -> None:
    rng = np.random.default_rng(0)
    frames = rng.normal(size=(50, 400))
    assert rain_layer.greatest_likeness(frames, 1) < 0.3
    frames[40] = frames[7]
    assert rain_layer.greatest_likeness(frames, 20) == pytest.approx(1.0)
    assert rain_layer.greatest_likeness(frames, 34) < 0.3


@pytest.mark.parametrize("weather", [HARD, FALLING], ids=["all", "falling"])
def test_rain_differs_between_seeds(weather: weathers.Weather) -> None:
    one, other = (rain_layer.layers(weather, seed, 12) for seed in (1, 2))
    assert np.abs(rain_layer.likeness(one, other)).max() < 0.3


@pytest.mark.slow
def test_falling_rain_does_not_repeat_within_ten_seconds() -> None:
    frames = rain_layer.layers(FALLING, 1, 600)
    assert rain_layer.greatest_likeness(frames, 2) < 0.5


@pytest.mark.parametrize("name", ["ClearNoon", "CloudySunset", "WetNoon", "FoggyNoon"])
def test_a_stationary_camera_in_still_weather_has_equal_frames(name: str) -> None:
    first, *others = (shot.image for shot in rain_layer.standing(90.0).shots(weathers.load(name), 2, 3))
    assert all(np.array_equal(first, other) for other in others)


def test_rain_changes_the_frames_of_a_stationary_camera() -> None:
    first, other = (shot.image for shot in rain_layer.standing(90.0).shots(HARD, 2, 2))
    assert np.count_nonzero((first != other).any(axis=2)) > 1000
