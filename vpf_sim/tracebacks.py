"""The cause of an exception in one line, from its traceback's text."""

import re
import sysconfig
from pathlib import Path

PLACE = re.compile(r'^ +File "(.+)", line (\d+)', re.MULTILINE)
NAMED = re.compile(r", line \d+\)$")  # a message that names its place
OURS = str(Path(__file__).parent)
STANDARD = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib")})
INSTALLED = {"site-packages", "dist-packages"}


def cause(traceback: str) -> str:
    """The exception with its message, and the file and line in a user's code where it happened."""
    lines = traceback.strip().splitlines()
    begins = max((number + 1 for number, line in enumerate(lines) if line.startswith(" ")), default=0)
    said = " ".join(line.strip() for line in lines[begins:] or lines[-1:])
    place = _place(PLACE.findall(traceback))
    return said if place is None or NAMED.search(said) else f"{said} ({place[0]}, line {place[1]})"


def _place(places: list[tuple[str, str]]) -> tuple[str, str] | None:
    """The innermost place in a user's code; in an installed package, that which we called; else the innermost."""
    own = [place for place in places if not (_is_library(place[0]) or place[0].startswith((OURS, "<")))]
    if own:
        return own[-1]
    last_of_ours = max((number for number, place in enumerate(places) if place[0].startswith(OURS)), default=-1)
    return next(iter(places[last_of_ours + 1 :] or places[-1:]), None)


def _is_library(file: str) -> bool:
    return file.startswith(STANDARD) or not INSTALLED.isdisjoint(Path(file).parts)
