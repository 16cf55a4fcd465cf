"""The page of the configuration: every key of every TOML file, from the fields of the configuration classes."""

from collections.abc import Iterator
from dataclasses import MISSING, dataclass
from typing import Any

from vpf_sim.cli.output import toml_value
from vpf_sim.configuration_fields import Setting, is_list, sections, settings_of
from vpf_sim.controllers import gtsmc, idm, pid, pure_pursuit, stanley
from vpf_sim.drivers.learned.manifest import Manifest
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.evaluation.gate.rules import Rules
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.planning import variant
from vpf_sim.replay.drive_file import DriveFile
from vpf_sim.scenarios.highway import HighwayEgo, HighwayEnv, HighwayGoal
from vpf_sim.scenarios.opendrive.road_section import OpenDriveFile
from vpf_sim.scenarios.random_road import RandomRoad
from vpf_sim.scenarios.schema import Scenario

HEAD = """# Configuration: every key of every TOML file

This page is made from the sources, as is what `vpf-sim scenarios keys`, `weathers keys` and `drivers keys` print. Units
are SI, and a part of a key's name.
A key without a default must be given; `none` stands for no value. A wrong file is refused with a line for each fault:
file, key, what was expected and what was found.
"""
VARIANT = """## Variant of the driver
`--driver vpf@FILE.toml` drives with a file of your own, which says what it changes. `base` names the variant or
ablation step it starts from; without it that is `robust`, the variant of `vpf`. A section can be taken whole from
another variant by its name, and `"none"` leaves an optional section out:
```toml
base = "robust"
gains = "super-twisting"
flow = "full-frame"
moving_obstacles = "none"
[road_edges]
lanes = 3
lane_width_m = 3.25
```
"""
GAINS = """## Gains of the controllers
In `controllers/gains.toml`; `gains` of a variant names a set of `[gtsmc]`.
"""


@dataclass(frozen=True, slots=True)
class OfRandom:
    """What a random scenario has and others have not."""

    random: RandomRoad


@dataclass(frozen=True, slots=True)
class OfHighwayEnv:
    """What a scenario on one of highway-env's roads has."""

    highway_env: HighwayEnv
    ego: HighwayEgo
    goal: HighwayGoal


FILES = (
    ("Scenario", "Sections of a scenario file. `base` lays a file over a scenario of the catalog.", Scenario),
    (
        "Scenario on a map",
        "The section `road` of a map stands in place of that above: [opendrive.md](opendrive.md).",
        OpenDriveFile,
    ),
    ("Random scenario", "The section `random` stands in place of `road`, `goal` and `bodies`.", OfRandom),
    (
        "Scenario of highway-env",
        "`highway_env` stands in place of `road` and `bodies`: [highway-env.md](highway-env.md).",
        OfHighwayEnv,
    ),
    ("Weather", "A weather file starts from `base`, a preset or an alias, by default `ClearNoon`.", Weather),
    ("Sweep", "A `sweep.toml` has lists, or single `drives` in place of scenario, weather and seeds.", Plan),
    ("Rules of the gate", "[gate.md](gate.md) explains the rules.", Rules),
    ("Learned policy", "`model.toml` beside `model.onnx`; [learning.md](learning.md) explains it.", Manifest),
    ("Recorded drive", "[recordings.md](recordings.md) explains `drive.toml`.", DriveFile),
)
Values = dict[str, Any]  # heading of a column -> the object that has the values


def page() -> str:
    """The whole page."""
    loaded = {"`vpf`": variant.load("robust"), "`vpf-paper`": variant.load("paper")}
    parts = [HEAD, VARIANT, *tables(variant.Variant, "", loaded)]
    parts += [
        GAINS,
        *tables(gtsmc.Gains, "[gtsmc]", {f"`{name}`": gtsmc.load_gains(name) for name in ("motion", "paper")}),
    ]
    for name, module in {"pid": pid, "pure_pursuit": pure_pursuit, "stanley": stanley, "idm": idm}.items():
        parts += tables(module.Gains, f"[{name}]", {"value": module.load_gains()})
    for title, about, config in FILES:
        parts += [f"## {title}\n{about}\n", *tables(config, "")]
    return "\n".join(parts)


def tables(config: type, path: str, values: Values | None = None) -> Iterator[str]:
    """A table for a section, with the heading `path`, and for each section in it; without `values` with defaults."""
    settings = settings_of(config)
    plain = [setting for setting in settings if not sections(setting.hint)]
    if plain:
        columns = ["key", "unit", "meaning", "bounds", *(values or {"default": None})]
        lines = [f"### {path}\n"] if path else []
        lines += [_row(columns), _row(["---"] * len(columns))]
        lines += [_row([*_about(setting), *_values(setting, values)]) for setting in plain]
        yield "\n".join(lines) + "\n"
    for setting in settings:
        name = f"{path.strip('[]')}.{setting.key}".removeprefix(".")
        listed = is_list(setting.hint)
        below = {one: getattr(values[one], setting.key, None) for one in values} if values and not listed else None
        for inner in sections(setting.hint):
            yield from tables(inner, f"[[{name}]]" if listed else f"[{name}]", below)


def _about(setting: Setting) -> list[str]:
    return [f"`{setting.key}`", setting.unit, setting.meaning, setting.bounds]


def _values(setting: Setting, values: Values | None) -> list[str]:
    if values is None:
        return ["" if setting.default is MISSING else toml_value(setting.default)]
    return ["-" if one is None else toml_value(getattr(one, setting.key)) for one in values.values()]


def _row(cells: list[str]) -> str:
    escaped = [cell.replace("|", "\\|") for cell in cells]
    return f"| {' | '.join(escaped)} |"
