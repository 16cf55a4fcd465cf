"""Scenarios by name or file, and a clear line for each fault of a wrong file."""

import re
import tomllib
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from vpf_sim.scenarios import parts
from vpf_sim.scenarios.schema import Scenario

from vpf_sim.errors import InputError, unknown_name

# The keys of every section, for the nearest name to a misspelt one.
SECTIONS: dict[str, type[BaseModel]] = {
    "": Scenario,
    "road": parts.Road,
    "road.segments.line": parts.Line,
    "road.segments.arc": parts.Arc,
    "road.segments.clothoid": parts.Clothoid,
    "ego": parts.Ego,
    "goal": parts.Goal,
    "bodies": parts.Body,
    "limits": parts.Limits,
}


def names() -> list[str]:
    """The scenarios of the catalog."""
    catalog = files("vpf_sim.scenarios.catalog")
    return sorted(entry.name.removesuffix(".toml") for entry in catalog.iterdir() if entry.name.endswith(".toml"))


def load(name_or_path: str) -> Scenario:
    """The scenario of that name in the catalog, or of that TOML file; InputError on anything wrong."""
    if name_or_path in names():
        text = (files("vpf_sim.scenarios.catalog") / f"{name_or_path}.toml").read_text("utf-8")
        return parse(text, f"{name_or_path}.toml")
    path = Path(name_or_path)
    if path.suffix != ".toml" and not path.is_file():
        raise unknown_name("scenario", name_or_path, names())
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise InputError(f"{name_or_path}: expected a readable scenario file, got: {reason}") from None
    return parse(text, name_or_path)


def parse(text: str, file: str) -> Scenario:
    """The scenario that a TOML text describes; `file` is how messages call it."""
    try:
        return Scenario.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{file}: expected TOML, got: {error}") from None
    except ValidationError as error:
        faults = error.errors(include_url=False)
        raise InputError("\n".join(line for fault in faults for line in _lines(file, dict(fault)))) from None


def _lines(file: str, fault: dict[str, Any]) -> list[str]:
    """What pydantic found, as one line (or one a fault where the parts do not fit together)."""
    location, kind = fault["loc"], fault["type"]
    if kind == "value_error":
        return [f"{file}: {line}" for line in str(fault["ctx"]["error"]).split("\n")]
    if kind == "extra_forbidden":
        return [f"{file}: {_key(location)}: unknown key, {_nearest(location)}"]
    if kind == "missing":
        return [f"{file}: {_key(location)}: expected a value, got none"]
    if kind == "union_tag_not_found":
        return [f"{file}: {_key(location)}.kind: expected one of 'line', 'arc', 'clothoid', got none"]
    if kind == "union_tag_invalid":
        tag = fault["ctx"]["tag"]
        return [f"{file}: {_key(location)}.kind: expected one of 'line', 'arc', 'clothoid', got '{tag}'"]
    remedy = _nearest_of(fault["input"], fault["ctx"]["expected"]) if kind == "literal_error" else ""
    return [f"{file}: {_key(location)}: {_expected(fault['msg'])}, got {_short(fault['input'])}{remedy}"]


def _key(location: tuple[int | str, ...]) -> str:
    """`bodies[1].lane` from pydantic's location, which puts the kind of a segment and "[key]" between."""
    key = ""
    for i, step in enumerate(location):
        if isinstance(step, int):
            key += f"[{step}]"
        elif step != "[key]" and not _is_segment_kind(location, i):
            key += f'."{step}"' if "." in step else f".{step}"
    return key.removeprefix(".")


def _is_segment_kind(location: tuple[int | str, ...], i: int) -> bool:
    return i == 3 and location[:2] == ("road", "segments")


def _nearest(location: tuple[int | str, ...]) -> str:
    """The remedy for an unknown key: the nearest of its section, or all of them."""
    section = SECTIONS[".".join(step for step in location[:-1] if isinstance(step, str))]
    known = [field.alias or name for name, field in section.model_fields.items()]
    near = get_close_matches(str(location[-1]), known, n=1, cutoff=0.5)
    return f"did you mean '{near[0]}'?" if near else f"known: {', '.join(known)}"


def _nearest_of(value: object, expected: str) -> str:
    """The nearest of the choices that pydantic lists in quotes."""
    near = get_close_matches(str(value), re.findall("'([^']+)'", expected), n=1, cutoff=0.5)
    return f": did you mean '{near[0]}'?" if near else ""


def _expected(message: str) -> str:
    """pydantic's 'Input should be X', in our words."""
    return (
        message.replace("Input should be", "expected", 1)
        if message.startswith("Input should")
        else f"expected: {message}"
    )


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
