"""Shell commands that messages and pages suggest."""

from pathlib import Path

from vpf_sim import system


def command(name: str, *arguments: str | Path, **options: str | Path | float | bool | None) -> str:
    """`vpf-sim NAME ARGUMENTS --option value`, quoted for the user's shell.

    Options that are None or False are omitted, True has no value; "_" in a name becomes "-".
    """
    words = ["vpf-sim", *name.split(), *map(_argument, arguments)]
    for option, value in options.items():
        if value is None or value is False:
            continue
        words.append(f"--{option.replace('_', '-')}")
        if value is not True:
            words.append(str(value))
    return system.quoted(words)


def _argument(value: str | Path) -> str:
    """The argument; a path that begins with a dash would be read as an option."""
    return f"./{value}" if str(value).startswith("-") else str(value)
