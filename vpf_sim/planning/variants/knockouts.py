"""The variant `robust` without one of its mechanisms: each optional section or value of its configuration is one.

The list is the configuration itself, so a mechanism that can be switched off can be measured without a further line.
"""

from vpf_sim.configuration_fields import optional_settings
from vpf_sim.planning.variants.ablation_steps import Table, at

NO = "no-"  # before the name of a mechanism
KEPT = (  # planners and methods, and what they cannot do without
    ("lane_planner",),
    ("paper_planner",),
    ("static_obstacles",),
    ("controller",),
    ("focus_of_expansion", "fit"),
)


def knockouts(config: type, robust: Table) -> dict[str, tuple[str, Table]]:
    """Summary and table of `robust` without one mechanism, by name: `no-` and its path with dashes."""
    return {
        NO + "-".join(path).replace("_", "-"): (f"without [{'.'.join(path)}]: {meaning}", _without(robust, path))
        for path, meaning in optional_settings(config)
        if path not in KEPT and at(robust, ".".join(path)) not in (None, "none")
    }


def _without(table: Table, path: tuple[str, ...]) -> Table:
    """The table with one mechanism switched off; all else is shared."""
    key, *inner = path
    return {**table, key: _without(table[key], tuple(inner)) if inner else "none"}
