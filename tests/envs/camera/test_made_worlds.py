"""An episode that is driven again looks the same, whatever was drawn in between."""

import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera.made_worlds import WORLDS
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.types import Camera

SMALL, SMALLER = Rig(camera=Camera(96, 72)), Rig(camera=Camera(64, 48))


def frames(env: FourLane, seed: int = 5, count: int = 3) -> list[bytes]:
    """Some frames from the reset on."""
    first, _ = env.reset(seed=seed)
    later = [env.step(np.array([0.5, 0.1]), ticks=6)[0] for _ in range(count)]
    return [observed["image"].tobytes() for observed in (first, *later)]


@pytest.mark.parametrize("weather", ["clear", "ClearNight", "rain"])
def test_it_is_the_same_after_others_on_the_same_road(weather: str) -> None:
    env = FourLane("town04", weather, rig=SMALL)
    first = frames(env)
    assert frames(env) == first, "at once"
    others = [
        FourLane("town04", "ClearSunset", rig=SMALL),
        FourLane("town04", weather, rig=SMALLER),
        FourLane("rows", rig=SMALL),
    ]
    assert all(frames(other) != first for other in others)
    assert frames(env, seed=6) != first
    assert frames(env) == first


def test_it_is_the_same_after_more_roads_than_are_kept() -> None:
    env = FourLane("straight", rig=SMALLER)
    first = frames(env, seed=0, count=0)
    assert len({tuple(frames(env, seed, count=0)) for seed in range(WORLDS + 3)}) > WORLDS
    assert frames(env, seed=0, count=0) == first


def test_objects_of_an_episode_are_not_in_another_on_the_same_road() -> None:
    scenario = scenarios.load("town04")
    full, empty = FourLane(scenario, rig=SMALL), FourLane(scenario.without_objects(), rig=SMALL)
    alone = frames(empty)
    beside = frames(full)
    assert beside != alone
    assert (frames(empty), frames(full)) == (alone, beside)
