"""Scenarios by name or file."""

from importlib.resources import files
from itertools import takewhile
from pathlib import Path
from typing import Any

from vpf_sim import configuration
from vpf_sim.errors import InputError, unknown_name
from vpf_sim.scenarios.opendrive import road_table
from vpf_sim.scenarios.random_road import RandomScenario
from vpf_sim.scenarios.schema import Scenario


def names() -> list[str]:
    """Names of the scenarios of the catalog."""
    catalog = files("vpf_sim.scenarios.catalog")
    return sorted(entry.name.removesuffix(".toml") for entry in catalog.iterdir() if entry.name.endswith(".toml"))


def summary(name: str) -> str:
    """What a scenario of the catalog is: the comment at the top of its file."""
    lines = (files("vpf_sim.scenarios.catalog") / f"{name}.toml").read_text("utf-8").splitlines()
    return " ".join(line.removeprefix("# ") for line in takewhile(lambda line: line.startswith("#"), lines))


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
    return _checked(configuration.read_file(path, "scenario"), name_or_path)


def parse(text: str, file: str) -> Scenario | RandomScenario:
    """The scenario that a TOML text describes; `file` is how messages call it."""
    return _checked(configuration.parse(text, file), file)


def _checked(content: dict[str, Any], file: str) -> Scenario | RandomScenario:
    content = _on_base(_with_map(content, file), file)
    if "random" in content:
        return configuration.build(RandomScenario, content, file, also=("base",))
    return configuration.build(Scenario, content, file, also=("base", "random"))


def _with_map(content: dict[str, Any], file: str) -> dict[str, Any]:
    """The tables of a file with the road of its OpenDRIVE map, if it names one."""
    road = content.get("road")
    if not isinstance(road, dict) or "opendrive" not in road:
        return content
    return {**content, "road": road_table(road, file)}


def _on_base(content: dict[str, Any], file: str) -> dict[str, Any]:
    """The tables of a file merged over the catalog's scenario `base`."""
    if "base" not in content:
        return content
    base = content["base"]
    if not isinstance(base, str):
        raise InputError(f"{file}: base: expected the name of a scenario, got {base!r}")
    if base not in names():
        raise InputError(f"{file}: base: {unknown_name('scenario', base, names())}")
    below = configuration.read("vpf_sim.scenarios.catalog", f"{base}.toml")
    return configuration.laid_over(below, {key: value for key, value in content.items() if key != "base"})
