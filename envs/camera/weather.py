"""Weather by CARLA's named factors. Only what the renderer shows is offered.

Names, ranges and presets are those of CARLA 0.9.16 (`carla.WeatherParameters`, PythonAPI/docs/weather.yml).
"""

import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from vpf_sim.errors import InputError, unknown_name, wrong_value


class Weather(BaseModel):
    """The light of one moment."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    name: str
    sun_altitude_angle: float = Field(default=45.0, ge=10.0, le=90.0)  # deg above the horizon
    sun_azimuth_angle: float = Field(default=215.0, ge=0.0, le=360.0)  # deg, clockwise from the world's X axis


PRESETS = {"ClearNoon": Weather(name="ClearNoon")}
ALIASES = {"clear": "ClearNoon"}


def names() -> list[str]:
    """The presets and their aliases."""
    return sorted([*PRESETS, *ALIASES])


def load(name_or_path: str) -> Weather:
    """The weather of a preset, an alias, or a TOML file with a `base` and factors of its own."""
    if name_or_path.endswith(".toml"):
        return _read(Path(name_or_path))
    name = ALIASES.get(name_or_path, name_or_path)
    if name not in PRESETS:
        raise unknown_name("weather", name_or_path, names())
    return PRESETS[name]


def _read(path: Path) -> Weather:
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise InputError(f"{path}: expected a readable weather file, got: {reason}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: expected TOML, got: {error}") from None
    base = content.pop("base", "ClearNoon")
    if not isinstance(base, str):
        raise InputError(f"{path}: base: expected the name of a weather, got {base!r}")
    if base not in names():
        raise InputError(f"{path}: base: {unknown_name('weather', base, names())}")
    factors = {**load(base).model_dump(), "name": path.stem, **content}
    try:
        return Weather.model_validate(factors)
    except ValidationError as error:
        raise InputError("\n".join(_line(path, fault) for fault in error.errors())) from None


def _line(path: Path, fault: Any) -> str:
    key = ".".join(str(part) for part in fault["loc"])
    if fault["type"] == "extra_forbidden":
        return f"{path}: {unknown_name('key', key, ['base', *Weather.model_fields])}"
    return f"{path}: {key}: {wrong_value(fault['msg'], fault['input'])}"
