"""Scores by dotted key, such as "accuracy.shadow.steering.range"; in JSON they are nested tables."""

from collections.abc import Iterable, Mapping
from math import isfinite
from sys import float_info
from typing import Any

import numpy as np

from vpf_sim.errors import shown

Number = float | None  # also bool and int; None where nothing was measured
Scores = Mapping[str, Number]
Json = dict[str, object]  # an object of a JSON file
LARGEST = float_info.max


def flat(table: Mapping[str, object]) -> dict[str, object]:
    """The values of nested tables by dotted key; an empty table is a value."""
    found: dict[str, object] = {}
    _flatten(table, "", found)
    return found


def _flatten(table: Mapping[str, object], prefix: str, found: dict[str, object]) -> None:
    for key, value in table.items():
        if isinstance(value, dict) and value:
            _flatten(value, f"{prefix}{key}.", found)
        else:
            found[prefix + key] = value


def nested(values: Mapping[str, object]) -> Json:
    """The tables of values by dotted key; None gives way to a table at the same key."""
    found: dict[str, Any] = {}
    for key, value in values.items():
        if "." not in key:
            if value is not None or key not in found:
                found[key] = value
            continue
        *tables, last = key.split(".")
        inner = found
        for name in tables:
            if not isinstance(inner.get(name), dict):
                inner[name] = {}
            inner = inner[name]
        if value is not None or last not in inner:
            inner[last] = value
    return found


def numbers(values: Mapping[str, object], tables: Iterable[str] = ()) -> dict[str, Number]:
    """The values as scores; ValueError for one that is no finite number, or no table at one of the keys `tables`."""
    for key, value in values.items():
        if value is not None and not (isinstance(value, (float, int)) and -LARGEST <= value <= LARGEST):
            raise ValueError(f"{key}: expected a valid number, got {shown(value)}")
    for key in tables:
        if values.get(key) is not None:
            raise ValueError(f"{key}: expected a table of numbers, got {shown(values[key])}")
    return dict(values)  # type: ignore[arg-type]


def finite(value: Any) -> Any:
    """The value with plain Python numbers, and None for nan and inf."""
    if isinstance(value, dict):
        return {key: finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not isfinite(value) else value
