"""Scenarios: files, schema and catalog."""

from vpf_sim.scenarios.files import load, names, parse, summary
from vpf_sim.scenarios.kinds import SIZES, ObjectKind, Size
from vpf_sim.scenarios.random_road import RandomScenario
from vpf_sim.scenarios.schema import Scenario

__all__ = ["SIZES", "ObjectKind", "RandomScenario", "Scenario", "Size", "load", "names", "parse", "summary"]
