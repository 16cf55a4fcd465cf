"""The settings of the variant `robust`, and the same with one mechanism switched off."""

import dataclasses
from collections.abc import Iterator
from functools import reduce
from typing import Any, TypeVar

from vpf_sim.perception.obstacles.config import StaticObstacleConfig
from vpf_sim.perception.obstacles.moving.config import MovingObstacleConfig
from vpf_sim.planning import variant

Config = TypeVar("Config")
ROBUST = variant.load("robust")


def static_obstacles() -> StaticObstacleConfig:
    assert ROBUST.static_obstacles is not None
    return ROBUST.static_obstacles


def section(path: str) -> Any:
    """The settings at a dotted path of the variant."""
    return reduce(getattr, path.split("."), ROBUST)


def moving_obstacles() -> MovingObstacleConfig:
    assert ROBUST.moving_obstacles is not None
    return ROBUST.moving_obstacles


def optional_sections(config: Any) -> Iterator[str]:
    """The dotted paths of the sections that may be None, also of those in other sections."""
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value):
            if field.default is None:
                yield field.name
            yield from (f"{field.name}.{path}" for path in optional_sections(value))


def without(config: Config, path: str) -> Config:
    """The configuration with the section at a dotted path switched off."""
    key, _, rest = path.partition(".")
    inner = without(getattr(config, key), rest) if rest else None
    return dataclasses.replace(config, **{key: inner})  # type: ignore[type-var]
