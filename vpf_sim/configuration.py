"""Configuration classes and the reader of all TOML files.

A configuration class names its fields once, with meaning and bounds; the name's suffix is the unit:

    @settings
    class FlowConfig:
        period_s: float = setting("Time between two tracked frames.", gt=0.0)
        max_level: int | None = setting("Pyramid levels; none: as many as the fastest motion needs.", ge=0)

`build` fills one from a table. Every fault is a line `where: section.key: expected X, got Y`.
"""

import dataclasses
import json
import tomllib
from collections.abc import Callable, Mapping
from functools import cache, wraps
from importlib.resources import files
from pathlib import Path
from types import NoneType
from typing import Any, TypeVar, cast, dataclass_transform, get_args

import pydantic
from pydantic import ConfigDict, TypeAdapter, ValidationError

from vpf_sim import configuration_faults
from vpf_sim.configuration_fields import keys, sections
from vpf_sim.errors import InputError
from vpf_sim.files import read_text

Config = TypeVar("Config")
TomlTable = dict[str, Any]  # as the file has it, before a configuration class checks it
STRICT = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


def setting(
    about: str,
    *,
    default: Any = dataclasses.MISSING,
    default_factory: Any = dataclasses.MISSING,
    gt: float | None = None,
    ge: float | None = None,
    lt: float | None = None,
    le: float | None = None,
    min_length: int | None = None,
) -> Any:
    """A field of a configuration class with its meaning and its bounds."""
    bounds = {"gt": gt, "ge": ge, "lt": lt, "le": le, "min_length": min_length}
    metadata = {"description": about, **{name: bound for name, bound in bounds.items() if bound is not None}}
    return dataclasses.field(default=default, default_factory=default_factory, metadata=metadata)


@dataclass_transform(frozen_default=True, field_specifiers=(setting, dataclasses.field))
def settings(cls: type[Config]) -> type[Config]:
    """Make a class a frozen dataclass that checks its values; a wrong one is a ValueError of one line a fault."""
    made: Any = pydantic.dataclasses.dataclass(frozen=True, slots=True, config=STRICT)(cls)
    made.__init__ = _in_our_words(made, made.__init__)
    return cast(type[Config], made)


def _in_our_words(cls: type, init: Callable[..., None]) -> Callable[..., None]:
    names = [field.name for field in dataclasses.fields(cls)]

    @wraps(init)
    def checked(self: Any, *args: Any, **values: Any) -> None:
        by_name = dict(zip(names, args, strict=False))  # a fault has a key, not a position
        try:
            init(self, *args[len(names) :], **by_name, **values)
        except ValidationError as error:
            raise ValueError("\n".join(configuration_faults.lines(cls, error.errors(include_url=False)))) from None

    return checked


def read(package: str, name: str) -> TomlTable:
    """The TOML file `name` that is installed with `package`."""
    return tomllib.loads(files(package).joinpath(name).read_text("utf-8"))


def read_file(path: Path, what: str) -> TomlTable:
    """The TOML file of a user; `what` is what it should be: "scenario"."""
    try:
        return parse(read_text(path), str(path))
    except (OSError, ValueError) as error:  # ValueError: bytes that are no text, or a name that no file can have
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise InputError(f"{path}: expected a readable {what} file, got: {reason}") from None


def parse(text: str, file: str) -> TomlTable:
    """The table that a TOML text describes; `file` is its name in messages."""
    try:
        return tomllib.loads(text)
    except ValueError as error:  # not TOML, or a number of thousands of digits
        raise InputError(f"{file}: expected TOML, got: {error}") from None
    except RecursionError:
        raise InputError(f"{file}: expected TOML, got brackets within brackets without end") from None


def laid_over(below: Mapping[str, Any], above: Mapping[str, Any]) -> TomlTable:
    """Tables merged key by key; any other value of `above` replaces that of `below`."""
    merged = dict(below)
    for key, value in above.items():
        nested = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = laid_over(merged[key], value) if nested else value
    return merged


def build(config: type[Config], table: Mapping[str, Any], where: str, also: tuple[str, ...] = ()) -> Config:
    """The configuration class `config` filled from `table`.

    The text "none" is None where a field may be None. `where` names the file in messages, `also` further keys that the
    table could have had. Raises InputError with a line for each fault.
    """
    text = json.dumps([_without_none(config, table)], default=str)  # as JSON: a list may fill a tuple
    try:
        built: Config = _adapter(config).validate_json(text)[0]  # type: ignore[arg-type]  # a class is hashable
    except ValidationError as error:
        found = [{**fault, "loc": fault["loc"][1:]} for fault in error.errors(include_url=False)]
        faults = configuration_faults.lines(config, found, also)
    else:
        faults = list(configuration_faults.too_large(table))
    if faults:
        raise InputError("\n".join(f"{where}: {fault}" for fault in faults))
    return built


@cache
def _adapter(config: Any) -> TypeAdapter[Any]:
    return TypeAdapter(tuple[config], config=STRICT)  # a tuple: else a plain dataclass is not strict


def _without_none(hint: Any, value: Any) -> Any:
    """A value of TOML with None for each "none" where None is allowed."""
    if value == "none" and NoneType in get_args(hint):
        return None
    known = {key: inner for section in sections(hint) for key, inner in keys(section).items()}
    if known and isinstance(value, list):
        return [_without_none(hint, item) for item in value]
    if known and isinstance(value, Mapping):
        return {key: _without_none(known.get(key), item) for key, item in value.items()}
    return value
