"""Scenarios: files, schema and catalog."""

from vpf_sim.scenarios.files import AnyScenario, as_table, drawn_road, load, names, of_table, parse, summary
from vpf_sim.scenarios.highway import HighwayScenario
from vpf_sim.scenarios.kinds import SIZES, ObjectKind, Size
from vpf_sim.scenarios.parts import Ability
from vpf_sim.scenarios.random_road import RandomScenario
from vpf_sim.scenarios.schema import Scenario

DrawnScenario = Scenario | HighwayScenario

__all__ = [
    "SIZES",
    "Ability",
    "AnyScenario",
    "DrawnScenario",
    "HighwayScenario",
    "ObjectKind",
    "RandomScenario",
    "Scenario",
    "Size",
    "as_table",
    "drawn_road",
    "load",
    "names",
    "of_table",
    "parse",
    "summary",
]
