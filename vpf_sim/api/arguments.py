"""Names and files that a caller gives as text or as paths."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

from vpf_sim.errors import InputError, option, shown

StrPath: TypeAlias = str | os.PathLike[str]
OF_A_RUN = ("manifest.json", "episodes.jsonl", "timing.jsonl", "summary.json")


def text(what: str, given: StrPath) -> str:
    """A name or path as text; InputError for anything else."""
    if not isinstance(given, str | os.PathLike) or not os.fspath(given):
        raise InputError(f"{option(what)}: expected a name or a path, got {shown(given)}")
    return os.fspath(given)


def texts(what: str, given: StrPath | Iterable[StrPath]) -> list[str]:
    """One name or path, or several, as a list of texts."""
    several = given if isinstance(given, Iterable) and not isinstance(given, str) else [given]
    return [text(what, one) for one in several]


def output_file(what: str, given: StrPath | None, ending: str = "") -> Path | None:
    """The path of an output file, if there is one; InputError, before a long computation, if it cannot be written.

    Its folder must exist, since a mistyped folder would be hard to find. The files that make a run are refused.
    """
    if given is None:
        return None
    path, where = Path(text(what, given)), option(what)
    if path.is_dir():
        raise InputError(f"{where}: {path}: expected the name of a file, got a folder")
    if not path.parent.is_dir():
        raise InputError(f"{where}: {path}: expected a folder that exists, found no {path.parent}")
    if path.name in OF_A_RUN and (path.parent / "manifest.json").exists():
        raise InputError(f"{where}: {path}: expected a file that the run does not need, got its {path.name}")
    if path.suffix.lower() != ending and ending:
        raise InputError(f"{where}: {path}: expected a name that ends in {ending}")
    return path
