"""Rain does not repeat."""

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
