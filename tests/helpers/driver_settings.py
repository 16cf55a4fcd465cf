"""Settings of the installed variants, for tests of single stages."""

import dataclasses
from collections.abc import Iterator
from functools import reduce
from types import NoneType
from typing import Any, TypeVar, get_args

from vpf_sim.configuration_fields import walk
from vpf_sim.perception.egomotion.egomotion_settings import ExpansionConfig, FocusFitConfig
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import MovingObstacleConfig
from vpf_sim.perception.obstacles.static_obstacle_settings import StaticObstacleConfig
from vpf_sim.planning.variant import load
from vpf_sim.scene.scene_settings import SceneConfig

Config = TypeVar("Config")
ROBUST, FULL_FRAME = load("robust"), load("full-frame")


def unwrap(section: Config | None) -> Config:
    """An optional section that the variant has."""
    assert section is not None
    return section


def focus_fit() -> FocusFitConfig:
    """Settings of the robust focus of expansion."""
    return unwrap(ROBUST.focus_of_expansion.fit)


def expansion(method: str) -> ExpansionConfig:
    """The robust variant's focus of expansion with another method."""
    return dataclasses.replace(ROBUST.focus_of_expansion, method=method)


def static_obstacles() -> StaticObstacleConfig:
    return unwrap(ROBUST.static_obstacles)


def scene() -> SceneConfig:
    return unwrap(ROBUST.scene)


def moving_obstacles() -> MovingObstacleConfig:
    return unwrap(ROBUST.moving_obstacles)


def section(path: str) -> Any:
    """The settings of `robust` at a dotted path."""
    return section_of(ROBUST, path)


def section_of(config: Any, path: str) -> Any:
    """The section at a dotted path; None where an outer one is switched off."""
    return reduce(lambda outer, key: getattr(outer, key, None), path.split("."), config)


def optional_sections(config: Any) -> Iterator[str]:
    """The dotted paths of the sections and values that may be None and are not, at any depth."""
    paths = [path for path, one in walk(type(config)) if NoneType in get_args(one.hint) and "[]" not in path]
    return (path for path in paths if section_of(config, path) is not None)
