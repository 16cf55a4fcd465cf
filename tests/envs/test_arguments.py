"""Both environments take the same words, and refuse others by name."""

from collections.abc import Callable
from typing import Any

import gymnasium
import pytest

import vpf_sim  # noqa: F401 (registers the environments)
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.learning import FourLanePixels
from vpf_sim.errors import InputError

IDS = ("vpf_sim/FourLane-v0", "vpf_sim/FourLanePixels-v0")


@pytest.mark.parametrize("name", IDS)
def test_scenario_and_weather_have_the_same_names(name: str) -> None:
    env: Any = gymnasium.make(name, scenario="blocked", weather="rain").unwrapped
    env.reset(seed=1)
    world = getattr(env, "world", env)
    assert world.scenario.goal.kind == "stop"
    assert world.weather.name == "HardRainNoon"


def test_several_scenarios_are_drawn_by_either_name() -> None:
    one = FourLanePixels(scenario=("straight", "curve-left"), weather=("clear", "rain"))
    other = FourLanePixels(scenarios=("straight", "curve-left"), weathers=("clear", "rain"))
    drawn = set()
    for seed in range(6):
        for env in (one, other):
            env.reset(seed=seed)
        assert one.world.scenario == other.world.scenario
        assert one.world.weather == other.world.weather
        drawn.add((str(one.world.scenario), one.world.weather.name))
    assert len(drawn) > 2


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        (IDS[0], {"scenarios": "straight"}, "unknown option 'scenarios': did you mean 'scenario'?"),
        (IDS[0], {"wheather": "rain"}, "unknown option 'wheather': did you mean 'weather'?"),
        (IDS[0], {"image_size": (84, 84)}, "unknown option 'image_size': known: frames, rate_hz, render_mode, rig,"),
        (IDS[1], {"size": (84, 84)}, "unknown option 'size': did you mean 'image_size'?"),
        (IDS[1], {"lidar": ("depth",)}, "unknown option 'lidar': known: action_repeat, fov_deg, grey, image_size,"),
        (IDS[1], {"image_size": (63, 48)}, "camera: width_px: expected at least 64, got 63"),
    ],
)
def test_other_options_are_refused(name: str, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        gymnasium.make(name, **options)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("make", [FourLane, FourLanePixels])
@pytest.mark.parametrize("options", [{"scenario": "rows"}, {"seed": 3}, ["seed"], 5])
def test_a_reset_has_no_options(make: Callable[[], Any], options: Any) -> None:
    env = make()
    with pytest.raises(InputError, match=r"^reset: options: expected none, got "):
        env.reset(seed=1, options=options)
    env.reset(seed=1, options={})
    env.reset(seed=1, options=None)
