"""Copied, pickled and multi-agent environments with the camera render the same frames."""

import copy
import pickle
import warnings
from typing import Any

import gymnasium as gym
import highway_env
import numpy as np
import pytest

import vpf_sim
from vpf_sim.envs.camera import Rig
from vpf_sim.types import Camera

SMALL = Rig(camera=Camera(160, 120))
MANY = "intersection-multi-agent-v1"

gym.register_envs(highway_env)
REGISTERED = sorted(name for name, spec in gym.registry.items() if "highway_env" in str(spec.entry_point))


def with_camera(name: str) -> Any:
    return vpf_sim.CameraObservation(plain(name), rig=SMALL)


def plain(name: str) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return gym.make(name, disable_env_checker=True)


def stored(env: Any) -> Any:
    return pickle.loads(pickle.dumps(env))


def assert_same_pictures(env: Any, twin: Any, steps: int) -> None:
    env.action_space.seed(1)
    for _ in range(steps):
        action = env.action_space.sample()
        assert np.array_equal(twin.step(action)[0]["image"], env.step(action)[0]["image"])


@pytest.mark.parametrize("duplicate", [copy.deepcopy, stored])
@pytest.mark.parametrize("weather", ["clear", "rain"])
@pytest.mark.parametrize("scenario", ["town04", "traffic", "intersection-v1"])
def test_copy_during_an_episode_renders_the_same_frames(scenario: str, weather: str, duplicate: Any) -> None:
    env = gym.make("vpf_sim/FourLane-v0", scenario=scenario, weather=weather, rig=SMALL, rate_hz=20.0)
    env.reset(seed=5)
    for _ in range(3):
        env.step(np.zeros(2))
    assert_same_pictures(env, duplicate(env), 3)


def test_steps_on_a_copy_do_not_change_the_original() -> None:
    env, other = with_camera("intersection-v0"), with_camera("intersection-v0")
    for each in (env, other):
        each.reset(seed=1)
    ahead = copy.deepcopy(env)
    for _ in range(3):
        ahead.step(2)
    assert_same_pictures(env, other, 2)


@pytest.mark.parametrize("name", [MANY, pytest.param("racetrack-v0", marks=pytest.mark.slow)])
def test_wrapper_does_not_change_the_environments_results(name: str) -> None:
    env, bare = with_camera(name), plain(name)
    env.reset(seed=1)
    bare.reset(seed=1)
    bare.action_space.seed(1)
    action = bare.action_space.sample()
    observation, *rest = env.step(action)
    expected, *expected_rest = bare.step(action)
    np.testing.assert_equal(observation["state"], expected)
    assert rest[:3] == expected_rest[:3]
    assert type(rest[0]) is type(expected_rest[0])
    assert env.observation_space["image"].contains(observation["image"])


@pytest.mark.slow
@pytest.mark.parametrize("name", REGISTERED)
def test_every_environment_takes_the_camera(name: str) -> None:
    env = with_camera(name)
    observation, _ = env.reset(seed=2)
    assert env.observation_space.contains(observation) or not env.env.observation_space.contains(
        env.env.reset(seed=2)[0]
    )
    env.reset(seed=2)
    assert_same_pictures(env, copy.deepcopy(env), 2)
    env.reset(seed=3)
    try:
        stored(plain(name))
    except (TypeError, AttributeError, pickle.PicklingError):
        return
    assert_same_pictures(env, stored(env), 1)


def test_vector_of_environments_equals_single_ones() -> None:
    vector = gym.vector.SyncVectorEnv([lambda: with_camera("merge-v0")] * 2)
    observation, _ = vector.reset(seed=[4, 5])
    for index, seed in enumerate((4, 5)):
        assert np.array_equal(observation["image"][index], with_camera("merge-v0").reset(seed=seed)[0]["image"])


def test_render_is_the_environments_own_view() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        bare = gym.make("merge-v0", render_mode="rgb_array", disable_env_checker=True)
    env = vpf_sim.CameraObservation(bare, rig=SMALL)
    env.reset(seed=1)
    assert np.array_equal(env.render(), bare.render())
    assert env.render().shape != env.observation_space["image"].shape


@pytest.mark.parametrize(
    ("name", "actions"),
    [
        ("merge-v0", [9, -1, np.nan, "x", [1, 1]]),
        ("racetrack-v0", [[np.nan], [0.0, 0.0], "x", None]),
        (MANY, [1, (1,), (1, 9), (np.nan, 0)]),
    ],
)
def test_invalid_action_is_rejected_with_a_clear_message(name: str, actions: list[Any]) -> None:
    env = with_camera(name)
    env.reset(seed=1)
    for action in actions:
        with pytest.raises(ValueError, match=r"^action: expected "):
            env.step(action)


def test_a_step_before_the_first_reset_is_refused() -> None:
    for env in (with_camera("merge-v0"), vpf_sim.CameraObservation(plain("merge-v0").unwrapped)):
        with pytest.raises(gym.error.ResetNeeded, match="reset"):
            env.step(0)
    for what in ("step", "render"):
        unwrapped: Any = gym.make("vpf_sim/FourLane-v0").unwrapped
        with pytest.raises(gym.error.ResetNeeded, match=rf"^{what}: expected reset\(\) first"):
            unwrapped.step(np.zeros(2)) if what == "step" else unwrapped.render()
