"""Paths in tables of recordings, as the machine wrote them that recorded: with its folders, its drive, its slashes."""

import os
import re
from collections.abc import Sequence
from pathlib import Path

SLASHES = re.compile(r"[/\\]")


def name_of(path: str) -> str:
    """The last part of a path of any system."""
    return SLASHES.split(path.strip())[-1]


def beside(folder: Path, path: str) -> Path:
    """The file in `folder` that a path of any system means; where there is none, the one that it should be.

    The longest end of the path that there is, is meant: of C:\\me\\drive\\center\\1.jpg this is center/1.jpg.
    """
    written = folder / path
    parts = [part for part in SLASHES.split(path.strip()) if part not in ("", ".", "..") and not part.endswith(":")]
    inside = [folder.joinpath(*parts[first:]) for first in range(len(parts))]
    ordered = [*inside, written] if written == Path(path) else [written, *inside]
    # os.path.exists, since that of Path raises on names that are too long.
    return next((file for file in ordered if os.path.exists(file)), folder.joinpath(*parts[-2:]))


def all_beside(folder: Path, paths: Sequence[str], suffixes: Sequence[str]) -> list[Path]:
    """The files that `paths` mean: as `beside`, else the only one of the name, with such an ending, in any folder."""
    found = [beside(folder, path) for path in paths]
    if all(os.path.exists(file) for file in found):
        return found
    anywhere: dict[str, list[Path]] = {}
    for file in folder.rglob("*"):
        if file.suffix.lower() in suffixes:
            anywhere.setdefault(file.name, []).append(file)
    only = {name: files[0] for name, files in anywhere.items() if len(files) == 1}
    return [file if os.path.exists(file) else only.get(file.name, file) for file in found]
