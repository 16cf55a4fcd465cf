"""Commands that messages and pages offer: a shell takes them as they stand."""

import shlex
from pathlib import Path


def command(name: str, *arguments: str | Path, **options: str | Path | float | bool | None) -> str:
    """`vpf-sim NAME ARGUMENTS --option value`, each word quoted where a shell needs it.

    An option that is None or False is left out, one that is True stands alone; "_" in its name is "-".
    """
    words = ["vpf-sim", *name.split(), *map(_argument, arguments)]
    for option, value in options.items():
        if value is None or value is False:
            continue
        words.append(f"--{option.replace('_', '-')}")
        if value is not True:
            words.append(str(value))
    return shlex.join(words)


def _argument(value: str | Path) -> str:
    """A path that begins with a dash would be taken for an option."""
    return f"./{value}" if str(value).startswith("-") else str(value)
