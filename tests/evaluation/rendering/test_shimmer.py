"""Rendered frames do not shimmer, and the measure detects shimmer."""

import numpy as np
import pytest

from vpf_sim.envs.camera import weather as weathers
from vpf_sim.evaluation.rendering import shimmer


@pytest.mark.parametrize("name", ["ClearNoon", "CloudySunset", "WetNoon", "FoggyNoon"])
def test_a_stationary_camera_in_still_weather_has_equal_frames(name: str) -> None:
    assert shimmer.changes_standing(weathers.load(name), "bend", seed=2, count=4) == 0


def test_rain_changes_the_frames_of_a_stationary_camera() -> None:
    assert shimmer.changes_standing(weathers.load("HardRainNoon"), "bend", seed=2, count=3) > 1000


@pytest.mark.parametrize("road", shimmer.STARTS_M)
@pytest.mark.parametrize("speed_mps", [1.0, 2.0])
def test_creeping_the_distant_ground_moves_as_it_should(road: str, speed_mps: float) -> None:
    seen = shimmer.creep(weathers.load("ClearNoon"), road, speed_mps, seed=1, count=42, every=7)
    assert seen.tracks > 100
    assert seen.off_1 < 0.01
    assert seen.off_6 < 0.01


def test_distant_ground_excludes_surroundings_of_objects() -> None:
    depth = np.tile(np.linspace(5.0, 100.0, 200)[::-1, None], (1, 300))
    instance = np.zeros((200, 300), np.int32)
    instance[80:90, 140:150] = 3
    found = shimmer.distant_ground({"depth": depth, "instance": instance})
    assert found[100, 20]
    assert not found[100, 145]
    assert not found[10, 20]  # 95 m
    assert not found[195, 20]  # 8 m
