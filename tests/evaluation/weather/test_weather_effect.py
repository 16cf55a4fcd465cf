"""The scripted drive in different weathers shows their effect."""

import numpy as np
import pytest

from vpf_sim.evaluation.weather import weather_effect
from vpf_sim.evaluation.weather.scorer import Score
from vpf_sim.evaluation.weather.weather_effect import Factor

FACTORS = {factor.name: factor for factor in weather_effect.factors()}


def measured(name: str) -> Score:
    return weather_effect.measure(FACTORS[name], seed=0, seconds=1.0, every=20)


def test_every_row_has_its_own_name() -> None:
    assert len(FACTORS) == len(weather_effect.factors())


def test_single_factors_leave_the_others_clear() -> None:
    clear = FACTORS["clear"].weather.model_dump()
    expected = {
        "no noise": set(),
        "slippery road": {"road_friction"},
        "wiper on dry glass": {"wiper_period_s"},
        "wet road reflections": {"wetness"},
        "puddles": {"precipitation_deposits"},
        "streaks": {"precipitation", "wind_intensity"},
        "droplets": {"droplets"},
    }
    for name, changed in expected.items():
        factors = FACTORS[name].weather.model_dump()
        assert {key for key in clear if factors[key] != clear[key]} == changed, name


def test_road_friction_does_not_change_frames() -> None:
    def frames(factor: Factor) -> list[bytes]:
        return [shot.image.tobytes() for shot in weather_effect.drive().shots(factor.weather, 0, 3)]

    assert frames(FACTORS["slippery road"]) == frames(FACTORS["clear"])


def test_clear_weather_has_no_difference_from_itself() -> None:
    score = measured("clear")
    assert score.changed == 0.0
    assert score.hidden == 0.0
    assert score.off == score.off_seen
    assert score.survive_1 > 0.9
    assert score.off < 0.3
    assert score.robust_foe_px < 5.0
    assert np.isfinite(list(score.__getstate__())).all()


@pytest.mark.slow
def test_water_on_windscreen_and_road_causes_most_errors() -> None:
    """Noise and haze hardly affect tracks, drops do, mostly where the truth says that they hide."""
    score = {name: measured(name) for name in ("clear", "noise of sd 4", "haze: fog of 50", "droplets", "HardRainNoon")}
    clear = score["clear"].off
    assert abs(score["noise of sd 4"].off - clear) < 0.05
    assert abs(score["haze: fog of 50"].off - clear) < 0.05
    for name in ("droplets", "HardRainNoon"):
        assert score[name].off > clear + 0.15, name
        assert score[name].off_seen < clear + 0.5 * (score[name].off - clear), name
        assert score[name].foe_px > score["clear"].foe_px, name
