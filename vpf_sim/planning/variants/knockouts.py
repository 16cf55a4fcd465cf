"""The variant `robust` without one of its mechanisms: each optional section of its configuration is one.

The list is the configuration itself, so a mechanism that can be switched off can be measured without a further line.
"""

from collections.abc import Iterator
from types import NoneType
from typing import get_args

from vpf_sim.configuration_fields import sections, settings_of
from vpf_sim.planning.variants.ablation_steps import Table

NO = "no-"  # before the name of a mechanism
KEPT = (  # planners and methods, and what they cannot do without
    ("lane_planner",),
    ("paper_planner",),
    ("static_obstacles",),
    ("controller",),
    ("focus_of_expansion", "fit"),
)


def knockouts(config: type, robust: Table) -> dict[str, tuple[str, Table]]:
    """Summary and table of `robust` without one mechanism, by name: `no-` and the section's path with dashes."""
    found: dict[str, tuple[str, Table]] = {}
    for path, meaning in _mechanisms(config, robust, ()):
        table = _without(robust, path)
        found[NO + "-".join(path).replace("_", "-")] = (f"without [{'.'.join(path)}]: {meaning}", table)
    return found


def _mechanisms(config: type, table: Table, above: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], str]]:
    """The paths of the optional sections that the table has, with their meanings."""
    for setting in settings_of(config):
        inner, own = sections(setting.hint), table.get(setting.key)
        if not inner or not isinstance(own, dict):
            continue
        path = (*above, setting.key)
        if NoneType in get_args(setting.hint) and path not in KEPT:
            yield path, setting.meaning
        yield from _mechanisms(inner[0], own, path)


def _without(table: Table, path: tuple[str, ...]) -> Table:
    """The table with a section switched off; the other sections are shared."""
    key, *inner = path
    return {**table, key: _without(table[key], tuple(inner)) if inner else "none"}
