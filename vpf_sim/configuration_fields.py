"""The fields of a configuration class: a `settings` class, a pydantic model or a plain dataclass."""

from collections.abc import Iterable, Iterator
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from typing import Any, Literal, get_args, get_origin, get_type_hints

SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
UNITS = {  # by suffix, longest first
    "_px_per_s": "px/s",
    "_rad_per_m": "rad/m",
    "_per_rad": "1/rad",
    "_per_m2": "1/m^2",
    "_per_s": "1/s",
    "_per_m": "1/m",
    "_radps3": "rad/s^3",
    "_radps2": "rad/s^2",
    "_radps": "rad/s",
    "_mps3": "m/s^3",
    "_mps2": "m/s^2",
    "_mps": "m/s",
    "_rad": "rad",
    "_deg": "deg",
    "_hz": "Hz",
    "_px": "px",
    "_m2": "m^2",
    "_ms": "ms",
    "_s": "s",
    "_m": "m",
}


@dataclass(frozen=True, slots=True)
class Setting:
    """A key of a file: its type, its meaning, what it may be, and its default (`MISSING`: none)."""

    key: str
    hint: Any
    meaning: str
    bounds: str
    default: Any

    @property
    def unit(self) -> str:
        """The unit that the key's suffix names; "" without one."""
        return next((unit for suffix, unit in UNITS.items() if self.key.endswith(suffix)), "")


@cache
def settings_of(config: Any) -> tuple[Setting, ...]:
    """The keys of a configuration class."""
    if hasattr(config, "__pydantic_fields__"):
        return tuple(
            Setting(
                field.alias or name,
                field.annotation,
                field.description or "",
                _bounds(field.annotation, field.metadata),
                MISSING if field.is_required() else field.get_default(call_default_factory=True),
            )
            for name, field in config.__pydantic_fields__.items()
        )
    hints = get_type_hints(config)
    return tuple(Setting(field.name, hints[field.name], "", "", field.default) for field in fields(config))


def keys(config: type) -> dict[str, Any]:
    """The keys of a configuration class in a file, with their types."""
    return {setting.key: setting.hint for setting in settings_of(config)}


def sections(hint: Any) -> list[type]:
    """The configuration classes in a type: [Line, Arc] of tuple[Line | Arc, ...]."""
    if isinstance(hint, type) and (is_dataclass(hint) or hasattr(hint, "__pydantic_fields__")):
        return [hint]
    return [section for option in get_args(hint) for section in sections(option)]


def is_list(hint: Any) -> bool:
    """Whether a type is a list in a file: tuple[Line, ...], or that or None."""
    return any(get_origin(one) is tuple for one in (hint, *get_args(hint)))


def walk(config: Any, outer: str = "") -> Iterator[tuple[str, Setting]]:
    """The dotted path of each key and section at any depth, with its setting; a section comes before its keys."""
    for setting in settings_of(config):
        path = f"{outer}{setting.key}"
        yield path, setting
        for section in sections(setting.hint):
            yield from walk(section, f"{path}[]." if is_list(setting.hint) else f"{path}.")


def _bounds(hint: Any, constraints: Iterable[Any]) -> str:
    """`> 0, <= 1`, or the choices of a Literal."""
    signs = [
        f"{sign} {getattr(one, name):g}" for one in constraints for name, sign in SIGNS.items() if hasattr(one, name)
    ]
    return ", ".join(dict.fromkeys([*signs, *_of_type(hint)]))


def _of_type(hint: Any) -> Iterator[str]:
    if get_origin(hint) is Literal:
        yield ", ".join(map(str, get_args(hint)))
    elif not sections(hint):
        for inner in get_args(hint):
            yield from _of_type(inner)
    for one in getattr(hint, "__metadata__", ()):  # of Annotated
        yield _bounds(None, one.metadata)
