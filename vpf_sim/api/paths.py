"""Names and files that a caller gives as text or as paths."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

from vpf_sim.errors import InputError

StrPath: TypeAlias = str | os.PathLike[str]


def texts(given: StrPath | Iterable[StrPath]) -> list[str]:
    """One name or path, or several, as a list of texts."""
    return [os.fspath(given)] if isinstance(given, str | os.PathLike) else [os.fspath(one) for one in given]


def path_or_none(given: StrPath | None) -> Path | None:
    """The path, if there is one."""
    return None if given is None else Path(given)


def check_output(what: str, path: Path | None) -> None:
    """InputError for an output file that cannot be written, raised before a long computation.

    Its folder must exist, since a mistyped folder would be hard to find.
    """
    if path is None:
        return
    if path.is_dir():
        raise InputError(f"{what}: {path}: expected the name of a file, got a folder")
    if not path.parent.is_dir():
        raise InputError(f"{what}: {path}: expected a folder that exists, found no {path.parent}")
