"""Frozen configuration from TOML tables: every key known, every type right, every fault one clear line."""

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from vpf_sim.errors import InputError

Config = TypeVar("Config")
LARGEST = 1e15  # of a number: no quantity in SI units is larger, and nan and inf are none


def read(package: str, name: str) -> dict[str, Any]:
    """The TOML file `name` that is installed with `package`."""
    return tomllib.loads(files(package).joinpath(name).read_text("utf-8"))


def read_file(path: Path, what: str) -> dict[str, Any]:
    """The TOML file of a user; `what` is what it should be: "scenario"."""
    try:
        return parse(path.read_text("utf-8"), str(path))
    except (OSError, ValueError) as error:  # ValueError: bytes that are no text, or a name that no file can have
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise InputError(f"{path}: expected a readable {what} file, got: {reason}") from None


def parse(text: str, file: str) -> dict[str, Any]:
    """The table that a TOML text describes; `file` is how messages call it."""
    try:
        return tomllib.loads(text)
    except ValueError as error:  # not TOML, or a number of thousands of digits
        raise InputError(f"{file}: expected TOML, got: {error}") from None
    except RecursionError:
        raise InputError(f"{file}: expected TOML, got brackets within brackets without end") from None


def build(config: type[Config], table: Mapping[str, Any], where: str) -> Config:
    """The dataclass `config` filled from `table`; `where` names the file and section in errors.

    Nested dataclasses take nested tables, and a field with a default may be left out. What a class checks in its
    `__post_init__` and refuses with ValueError is told with the same prefix.
    """
    known = {item.name: item for item in fields(config)}  # type: ignore[arg-type]
    hints = get_type_hints(config)
    for key in table:
        if key not in known:
            near = get_close_matches(key, known, n=1, cutoff=0.5)
            remedy = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(known)}"
            raise InputError(f"{where}: unknown key {_shown(key)}: {remedy}")
    for key, item in known.items():
        if key not in table and item.default is MISSING and item.default_factory is MISSING:
            raise InputError(f"{where}: key '{key}' is missing")
    values = {key: _convert(hints[key], value, f"{where}: {key}") for key, value in table.items()}
    try:
        return config(**values)
    except ValueError as error:
        raise InputError(f"{where}: {error}") from None


def _convert(hint: Any, value: Any, where: str) -> Any:
    """`value` of a TOML file as what the type hint asks for."""
    origin = get_origin(hint)
    if origin is Literal:
        return _choice(get_args(hint), value, where)
    if origin in (Union, UnionType):
        if value == "none":  # TOML has no word for it
            return None
        return _convert(next(option for option in get_args(hint) if option is not NoneType), value, where)
    if origin is tuple:
        return _sequence(get_args(hint), value, where)
    if is_dataclass(hint) and isinstance(hint, type):
        if not isinstance(value, Mapping):
            raise InputError(f"{where}: expected a table, got {_shown(value)}")
        return build(hint, value, where)
    return _scalar(hint, value, where)


def _shown(value: Any) -> str:
    """A value of any length and letters, in a line."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _choice(options: tuple[Any, ...], value: Any, where: str) -> Any:
    if value not in options:
        raise InputError(f"{where}: expected one of {', '.join(map(str, options))}, got {_shown(value)}")
    return value


def _sequence(hints: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise InputError(f"{where}: expected a list, got {_shown(value)}")
    if hints[-1] is Ellipsis:
        hints = (hints[0],) * len(value)
    if len(value) != len(hints):
        raise InputError(f"{where}: expected {len(hints)} values, got {len(value)}")
    return tuple(_convert(hint, item, where) for hint, item in zip(hints, value, strict=True))


def _scalar(hint: Any, value: Any, where: str) -> Any:
    number = isinstance(value, int) and not isinstance(value, bool)
    if hint is float and (number or isinstance(value, float)):
        if not abs(value) <= LARGEST:
            raise InputError(f"{where}: expected a number up to {LARGEST:g}, got {str(value)[:40]}")
        return float(value)
    right = number if hint is int else isinstance(value, hint)
    if not right:
        raise InputError(f"{where}: expected {hint.__name__}, got {_shown(value)}")
    return value
