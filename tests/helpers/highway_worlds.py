"""Worlds of highway-env scenarios, and the environments themselves to compare them with."""

import json
import warnings
from typing import Any, get_args

import gymnasium
import highway_env

from vpf_sim import scenarios
from vpf_sim.envs.world import World, build_world
from vpf_sim.scenarios.highway import HighwayId

gymnasium.register_envs(highway_env)
IDS: tuple[str, ...] = get_args(HighwayId)
LATER = ("-v1", "-v2")  # versions with the road of an older one
ROADS = [name for name in IDS if name == "intersection-v1" or not name.endswith((*LATER, "intersection-v0"))]


def scenario(name: str, **config: Any) -> Any:
    """A highway-env scenario with keys of its configuration."""
    keys = ", ".join(f"{key} = {json.dumps(value)}" for key, value in config.items())
    return scenarios.parse(f'schema = 1\n[highway_env]\nid = "{name}"\nconfig = {{{keys}}}\n', "test.toml")


def empty(name: str, **config: Any) -> Any:
    """The same without traffic."""
    return scenario(name, **config).without_objects()


def world(name: str, seed: int = 0, **config: Any) -> World:
    """The world of a seed."""
    return build_world(scenario(name, **config), seed)


def original(name: str, seed: int, **config: Any) -> Any:
    """highway-env's own environment after a reset with that seed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env: Any = gymnasium.make(name, config=config, disable_env_checker=True).unwrapped
    env.reset(seed=seed)
    return env
