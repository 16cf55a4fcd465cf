"""Loads scenarios by name or file; each fault of a file is one clear line."""

import re
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from vpf_sim import tables
from vpf_sim.errors import InputError, unknown_name, wrong_value
from vpf_sim.scenarios import parts
from vpf_sim.scenarios.random_road import RandomRoad, RandomScenario
from vpf_sim.scenarios.schema import Scenario

# The keys of every section, to suggest the nearest name for a misspelt one.
SECTIONS: dict[str, type[BaseModel]] = {
    "": Scenario,
    "road": parts.Road,
    "road.look": parts.RoadAppearance,
    "road.segments.line": parts.Line,
    "road.segments.arc": parts.Arc,
    "road.segments.clothoid": parts.Clothoid,
    "ego": parts.Ego,
    "ego.sensors": parts.Sensors,
    "ego.sensor_faults": parts.SensorFaults,
    "goal": parts.Goal,
    "bodies": parts.ObjectSpec,
    "limits": parts.Limits,
    "random": RandomRoad,
    "random.look": parts.RoadAppearance,
}


def names() -> list[str]:
    """Names of the scenarios of the catalog."""
    catalog = files("vpf_sim.scenarios.catalog")
    return sorted(entry.name.removesuffix(".toml") for entry in catalog.iterdir() if entry.name.endswith(".toml"))


def load(name_or_path: str | Scenario | RandomScenario) -> Scenario | RandomScenario:
    """The scenario of a catalog name or a TOML file; a loaded scenario is returned as it is. Raises InputError."""
    if isinstance(name_or_path, Scenario | RandomScenario):
        return name_or_path
    if not isinstance(name_or_path, str):
        raise InputError(f"scenario: expected a name, a TOML file or a Scenario, got {name_or_path!r}")
    if name_or_path in names():
        text = (files("vpf_sim.scenarios.catalog") / f"{name_or_path}.toml").read_text("utf-8")
        return parse(text, f"{name_or_path}.toml")
    path = Path(name_or_path)
    if path.suffix != ".toml" and not path.is_file():
        raise unknown_name("scenario", name_or_path, names())
    return _checked(tables.read_file(path, "scenario"), name_or_path)


def parse(text: str, file: str) -> Scenario | RandomScenario:
    """The scenario of a TOML text; `file` is its name in messages."""
    return _checked(tables.parse(text, file), file)


def _checked(content: dict[str, Any], file: str) -> Scenario | RandomScenario:
    content = _on_base(content, file)
    try:
        return (RandomScenario if "random" in content else Scenario).model_validate(content)
    except ValidationError as error:
        faults = _causes([dict(fault) for fault in error.errors(include_url=False)])
        raise InputError("\n".join(line for fault in faults for line in _lines(file, fault))) from None


def _on_base(content: dict[str, Any], file: str) -> dict[str, Any]:
    """The tables of a file merged over the catalog's scenario `base`."""
    if "base" not in content:
        return content
    base = content["base"]
    if not isinstance(base, str):
        raise InputError(f"{file}: base: expected the name of a scenario, got {base!r}")
    if base not in names():
        raise InputError(f"{file}: base: {unknown_name('scenario', base, names())}")
    below = tables.read("vpf_sim.scenarios.catalog", f"{base}.toml")
    return _laid_over(below, {key: value for key, value in content.items() if key != "base"})


def _laid_over(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Tables merged recursively; values of `above` replace those of `below`."""
    merged = dict(below)
    for key, value in above.items():
        nested = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _laid_over(merged[key], value) if nested else value
    return merged


def _causes(faults: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Faults without consequences of others: missing keys that are misspelt, lists too short by invalid elements."""
    misspelt = {(*fault["loc"][:-1], _near(fault["loc"])) for fault in faults if fault["type"] == "extra_forbidden"}
    places = [fault["loc"] for fault in faults]
    return [
        fault
        for fault in faults
        if not (fault["type"] == "missing" and fault["loc"] in misspelt)
        and not (
            fault["type"] == "too_short"
            and any(place[: len(fault["loc"])] == fault["loc"] != place for place in places)
        )
    ]


def _lines(file: str, fault: dict[str, Any]) -> list[str]:
    """A pydantic error as lines: one, or one per inconsistency between sections."""
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
    return [f"{file}: {_key(location)}: {wrong_value(fault['msg'], fault['input'])}{remedy}"]


def _key(location: tuple[int | str, ...]) -> str:
    """`bodies[1].lane` from pydantic's location, without its segment kinds and "[key]"."""
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
    """A suggestion for an unknown key: the nearest key of its section, or all of them."""
    near = _near(location)
    return f"did you mean '{near}'?" if near else f"known: {', '.join(_known(location))}"


def _near(location: tuple[int | str, ...]) -> str | None:
    """The key of the same section nearest to an unknown one."""
    return next(iter(get_close_matches(str(location[-1]), _known(location), n=1, cutoff=0.5)), None)


def _known(location: tuple[int | str, ...]) -> list[str]:
    """The keys of a key's section."""
    section = SECTIONS[".".join(step for step in location[:-1] if isinstance(step, str))]
    fields = {**section.model_fields, **(RandomScenario.model_fields if section is Scenario else {})}
    return [*(["base"] if section is Scenario else []), *(field.alias or name for name, field in fields.items())]


def _nearest_of(value: object, expected: str) -> str:
    """A suggestion from the choices that pydantic lists in quotes."""
    near = get_close_matches(str(value), re.findall("'([^']+)'", expected), n=1, cutoff=0.5)
    return f": did you mean '{near[0]}'?" if near else ""
