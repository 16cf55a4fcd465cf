"""Prints the keys of a TOML file, from the fields of its configuration class."""

from dataclasses import MISSING
from typing import Any

from vpf_sim.cli.options import print_json
from vpf_sim.cli.tables import print_table
from vpf_sim.configuration_fields import Setting, sections, walk


def print_keys(config: type, json: bool) -> None:
    """Print each key with its default, its meaning and its bounds."""
    rows = [
        {"key": path, "default": _default(one), "meaning": one.meaning, "bounds": one.bounds}
        for path, one in walk(config)
        if not sections(one.hint)
    ]
    if json:
        print_json({"keys": rows})
        return
    for row in rows:
        row["meaning"] += f" ({row.pop('bounds')})" if row["bounds"] else ""
    print_table(("key", "default", "meaning"), [[row[key] for key in ("key", "default", "meaning")] for row in rows], 3)


def _default(setting: Setting) -> str:
    return "" if setting.default is MISSING else toml_value(setting.default)


def toml_value(value: Any) -> str:
    """A value as a TOML file has it; none stands for no value."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, bool | None):
        return "none" if value is None else str(value).lower()
    return repr(value) if isinstance(value, float | int) else str(value)
