"""Resolves paths in tables that another machine wrote, with its folders, drives and slashes."""

import os
import re
from collections.abc import Sequence
from pathlib import Path

SLASHES = re.compile(r"[/\\]")


def name_of(path: str) -> str:
    """The last part of a path of any system."""
    return SLASHES.split(path.strip())[-1]


def resolve(folder: Path, path: str) -> Path:
    """The file in `folder` that a path of any system refers to, or where it should be.

    The longest existing end of the path is taken: center/1.jpg for C:\\me\\drive\\center\\1.jpg.
    """
    written = folder / path
    parts = [part for part in SLASHES.split(path.strip()) if part not in ("", ".", "..") and not part.endswith(":")]
    inside = [folder.joinpath(*parts[first:]) for first in range(len(parts))]
    ordered = [*inside, written] if written == Path(path) else [written, *inside]
    # os.path.exists, since Path.exists raises on names that are too long.
    return next((file for file in ordered if os.path.exists(file)), folder.joinpath(*parts[-2:]))


def resolve_all(folder: Path, paths: Sequence[str], suffixes: Sequence[str]) -> list[Path]:
    """The files that `paths` refer to.

    A file that is not found by `resolve` may be the only one of its name, with one of the suffixes, in any folder.
    """
    found = [resolve(folder, path) for path in paths]
    if all(os.path.exists(file) for file in found):
        return found
    anywhere: dict[str, list[Path]] = {}
    for file in folder.rglob("*"):
        if file.suffix.lower() in suffixes:
            anywhere.setdefault(file.name, []).append(file)
    only = {name: files[0] for name, files in anywhere.items() if len(files) == 1}
    return [file if os.path.exists(file) else only.get(file.name, file) for file in found]
