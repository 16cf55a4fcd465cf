"""Scores by dotted key, such as "accuracy.shadow.steering.range"; in JSON they are nested tables."""

from collections.abc import Iterator, Mapping
from math import isfinite
from sys import float_info
from typing import Any

import numpy as np

from vpf_sim.errors import shown

Number = float | None  # also bool and int; None where nothing was measured
Scores = Mapping[str, Number]
Json = dict[str, object]  # an object of a JSON file
LARGEST = float_info.max


def flat(table: Mapping[str, object]) -> dict[str, Number]:
    """The scores of nested tables by dotted key; ValueError for a value that is no finite number."""
    found: dict[str, Number] = {}
    _flatten(table, "", found)
    return found


def _flatten(table: Mapping[str, object], prefix: str, found: dict[str, Number]) -> None:
    for name, value in table.items():
        key = prefix + name
        if value is None or (isinstance(value, (float, int)) and -LARGEST <= value <= LARGEST):
            found[key] = value
        elif isinstance(value, dict) and value:
            _flatten(value, f"{key}.", found)
        else:
            raise ValueError(f"{key}: expected a valid number, got {shown(value)}")


def leaves(table: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """The values of nested tables with their dotted keys; an empty table is a value."""
    for name, value in table.items():
        if isinstance(value, dict) and value:
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


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


def finite(value: Any) -> Any:
    """The value with plain Python numbers, and None for nan and inf."""
    if isinstance(value, dict):
        return {key: finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not isfinite(value) else value
