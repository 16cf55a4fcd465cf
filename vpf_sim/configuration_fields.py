"""The fields of a configuration class: a `settings` class, a pydantic model or a plain dataclass."""

from dataclasses import fields, is_dataclass
from typing import Any, get_args, get_type_hints


def keys(config: type) -> dict[str, Any]:
    """The keys of a configuration class in a file, with their types."""
    if hasattr(config, "__pydantic_fields__"):
        return {field.alias or name: field.annotation for name, field in config.__pydantic_fields__.items()}
    hints = get_type_hints(config)
    return {field.name: hints[field.name] for field in fields(config)}


def sections(hint: Any) -> list[type]:
    """The configuration classes in a type: [Line, Arc] of tuple[Line | Arc, ...]."""
    if isinstance(hint, type) and (is_dataclass(hint) or hasattr(hint, "__pydantic_fields__")):
        return [hint]
    return [section for option in get_args(hint) for section in sections(option)]
