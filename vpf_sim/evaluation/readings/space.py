"""The space of readings, and the variant of a reading.

A reading has one value for each quantity of space.toml. Two unprinted gains, gamma and lambda, are parameterised by
their effect, so that one range fits all readings: a change of sigma or of the road's edges shifts them by orders of
magnitude.
"""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from math import exp
from typing import Any

import numpy as np

from vpf_sim import configuration
from vpf_sim.perception.paper.obstacle_map import rasterise, smoothed_gradient
from vpf_sim.planning import variant
from vpf_sim.planning.variants.ablation_steps import Table, put
from vpf_sim.types import Camera

BASE = "full-frame"  # the base variant of all readings
WHOLE = "of robust"  # marks a section that is copied from the variant `robust`
FAR_M = 100.0  # assumed distance of the far goal when its force is compared with the others
EDGES_M = {"carriageway": (5.25, -8.75), "lane": (1.75, -1.75), "preferred": (5.25, -5.25)}  # of the paper's road
BOX_PX = (390.0, 450.0, 210.0, 270.0)  # left, right, top, bottom of the reference obstacle of `push`

Reading = Mapping[str, str | float]  # quantity -> name of a choice, or number


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity that the paper leaves open: named choices, or a range."""

    name: str
    about: str
    sources: Mapping[str, str]  # choice -> source; key "" for a range
    choices: Mapping[str, Mapping[str, Any]]  # choice -> dotted key of a variant -> value
    low: float = 0.0
    high: float = 0.0


def quantities() -> tuple[Quantity, ...]:
    """The quantities of space.toml."""
    return tuple(_quantity(name, table) for name, table in configuration.read(__package__, "space.toml").items())


def known() -> tuple[Reading, ...]:
    """The readings of known.toml, which are tried first."""
    return tuple(configuration.read(__package__, "known.toml").values())


def _quantity(name: str, table: Mapping[str, Any]) -> Quantity:
    if "choices" not in table:
        return Quantity(name, table["about"], {"": table["source"]}, {}, table["low"], table["high"])
    sources = {choice: sets["source"] for choice, sets in table["choices"].items()}
    choices = {
        choice: {key: value for key, value in sets.items() if key != "source"}
        for choice, sets in table["choices"].items()
    }
    return Quantity(name, table["about"], sources, choices)


def variant_table(reading: Reading) -> Table:
    """The variant table of a reading."""
    table = {"base": BASE, **variant.table(BASE)}
    for quantity in quantities():
        for key, value in quantity.choices.get(str(reading[quantity.name]), {}).items():
            whole = variant.table("robust")[key] if value == WHOLE else value
            put(table, key, deepcopy(whole))
    line = table["paper_planner"]
    target_n = line["target_field"]["alpha"] * line["target_field"].get("reach_m", FAR_M)
    line["obstacle_field"]["gamma"] = rounded(float(reading["push"]) * target_n / _push_of_one(table))
    lambda_y = rounded(float(reading["stiffness"]) * target_n / _stiffness_of_one(line["road_field"]))
    line["total_field"] |= {"lambda_x": lambda_y, "lambda_y": lambda_y}
    return table


def rounded(value: float) -> float:
    """A gain rounded to three digits."""
    return float(f"{value:.2e}")


def _push_of_one(table: Table) -> float:
    """The obstacle force of the reference obstacle with gamma = 1."""
    config = replace(variant.load(BASE).obstacle_map, sigma_px=table["obstacle_map"]["sigma_px"])
    left, right, top, bottom = BOX_PX
    step = 0.5 * config.reduction
    grid = np.meshgrid(np.arange(left, right, step), np.arange(top, bottom, step))
    plane = rasterise(np.stack([axis.ravel() for axis in grid], axis=1), Camera(), config)
    force = float(smoothed_gradient(plane, config)[0].mean())
    return force / float(plane.mean()) if table["paper_planner"]["obstacle_field"].get("area") == "obstacles" else force


def _stiffness_of_one(road: Table) -> float:
    """The second derivative of the road's potential at its minimum, 1/m2: 4 A b^2 E (2 E - 1), E = e^(b width / 2)."""
    right_m, left_m = EDGES_M[road.get("edges", "carriageway")]
    b = road["b_per_m"]
    rise = exp(0.5 * b * (right_m - left_m))
    return float(4.0 * road["depth"] * b**2 * rise * (2.0 * rise - 1.0))


def toml(table: Table, head: str = "") -> str:
    """A variant's table as a TOML file."""
    plain = {key: value for key, value in table.items() if not isinstance(value, dict)}
    lines = [f"[{head}]"] if head and (plain or not table) else []
    lines += [f"{key} = {_written(value)}" for key, value in plain.items()]
    parts = ["\n".join(lines)] if lines else []
    for key, value in table.items():
        if isinstance(value, dict):
            parts.append(toml(value, f"{head}.{key}" if head else key))
    return "\n\n".join(part.rstrip("\n") for part in parts) + "\n"


def _written(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {_written(one)}' for key, one in value.items())}}}"
    return f"[{', '.join(map(_written, value))}]" if isinstance(value, list) else repr(value)
