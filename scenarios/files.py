"""Scenarios by name or file."""

from importlib.resources import files
from itertools import takewhile
from pathlib import Path
from typing import get_args

from vpf_sim import configuration
from vpf_sim.configuration import TomlTable
from vpf_sim.errors import InputError, unknown_name
from vpf_sim.scenarios.highway import HighwayId, HighwayScenario
from vpf_sim.scenarios.opendrive import road_table
from vpf_sim.scenarios.random_road import RandomScenario
from vpf_sim.scenarios.schema import Scenario

AnyScenario = Scenario | RandomScenario | HighwayScenario
CATALOG = "vpf_sim.scenarios.catalog"


def names() -> list[str]:
    """Names of the scenarios of the catalog."""
    catalog = files(CATALOG)
    return sorted(entry.name.removesuffix(".toml") for entry in catalog.iterdir() if entry.name.endswith(".toml"))


def summary(name: str) -> str:
    """What a scenario of the catalog is: the comment at the top of its file."""
    lines = (files(CATALOG) / f"{name}.toml").read_text("utf-8").splitlines()
    return " ".join(line.removeprefix("# ") for line in takewhile(lambda line: line.startswith("#"), lines))


def load(name_or_path: str | Path | AnyScenario) -> AnyScenario:
    """The scenario of a catalog name or a TOML file; a loaded scenario is returned as it is. Raises InputError."""
    if isinstance(name_or_path, AnyScenario):
        return name_or_path
    if not isinstance(name_or_path, str | Path):
        raise InputError(f"scenario: expected a name, a TOML file or a Scenario, got {name_or_path!r}")
    name_or_path = str(name_or_path)
    if name_or_path in names():
        text = (files(CATALOG) / f"{name_or_path}.toml").read_text("utf-8")
        return parse(text, f"{name_or_path}.toml")
    path = Path(name_or_path)
    if path.suffix != ".toml" and not path.is_file():
        raise unknown_name("scenario", name_or_path, names())
    return of_table(configuration.read_file(path, "scenario"), name_or_path)


def drawn_road(name_or_path: str, seed: int) -> Scenario:
    """A scenario with a road of our own, as a seed draws it. Raises InputError for one of highway-env's roads."""
    drawn = load(name_or_path).draw(seed)
    if not isinstance(drawn, Scenario):
        raise InputError(f"scenario: expected one with a road of its own, got {name_or_path}, a road of highway-env")
    return drawn


def parse(text: str, file: str) -> AnyScenario:
    """The scenario that a TOML text describes; `file` is how messages call it."""
    return of_table(configuration.parse(text, file), file)


def as_table(scenario: AnyScenario) -> TomlTable:
    """The tables of a file that says the same as a scenario, without a base or a map: `of_table` reads them."""
    return scenario.model_dump(mode="json", by_alias=True)


def of_table(content: TomlTable, file: str) -> AnyScenario:
    """The scenario that the tables of a file describe; `file` is how messages call it."""
    content = _on_base(_with_map(content, file), file)
    if "highway_env" in content:
        return configuration.build(HighwayScenario, _on_its_id(content), file, also=("base",))
    if "random" in content:
        return configuration.build(RandomScenario, content, file, also=("base",))
    return configuration.build(Scenario, content, file, also=("base", "random", "highway_env"))


def _with_map(content: TomlTable, file: str) -> TomlTable:
    """The tables of a file with the road of its OpenDRIVE map, if it names one."""
    road = content.get("road")
    if not isinstance(road, dict) or "opendrive" not in road:
        return content
    return {**content, "road": road_table(road, file)}


def _on_base(content: TomlTable, file: str) -> TomlTable:
    """The tables of a file merged over the catalog's scenario `base`."""
    if "base" not in content:
        return content
    base = content["base"]
    if not isinstance(base, str):
        raise InputError(f"{file}: base: expected the name of a scenario, got {base!r}")
    if base not in names():
        raise InputError(f"{file}: base: {unknown_name('scenario', base, names())}")
    return _over(base, {key: value for key, value in content.items() if key != "base"})


def _on_its_id(content: TomlTable) -> TomlTable:
    """The tables of a highway-env scenario merged over the catalog's scenario of its id."""
    section = content["highway_env"]
    name = section.get("id") if isinstance(section, dict) else None
    return _over(str(name) if name in get_args(HighwayId) else "highway-v0", content)


def _over(base: str, content: TomlTable) -> TomlTable:
    below = _on_base(configuration.read(CATALOG, f"{base}.toml"), f"{base}.toml")
    return configuration.laid_over(below, content)
