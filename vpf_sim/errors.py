"""Errors of the user, one line each."""

import re
import sysconfig
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from difflib import get_close_matches
from inspect import Parameter, signature
from pathlib import Path
from textwrap import shorten
from typing import Any

_COMMAND_LINE = ContextVar("command_line", default=False)


MOST_NAMES_LENGTH = 600  # characters of a list of names in a message
PLACE = re.compile(r'^ +File "(.+)", line (\d+)', re.MULTILINE)
NAMED = re.compile(r", line \d+\)$")  # a message that names its place
OURS = str(Path(__file__).parent)
STANDARD = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib")})
INSTALLED = {"site-packages", "dist-packages"}


class InputError(Exception):
    """Wrong use or wrong input; the command line prints the message and exits with 2.

    A message may quote what a user's file holds; what cannot be printed of it is escaped.
    """

    def __init__(self, message: str) -> None:
        super().__init__("".join(one if one.isprintable() or one == "\n" else ascii(one)[1:-1] for one in message))


@contextmanager
def on_command_line() -> Iterator[None]:
    """A context in which messages name options of the command line, not parameters of Python's functions."""
    token = _COMMAND_LINE.set(True)
    try:
        yield
    finally:
        _COMMAND_LINE.reset(token)


def is_on_command_line() -> bool:
    """Whether the user reads messages of a command, not of a Python function."""
    return _COMMAND_LINE.get()


def option(name: str) -> str:
    """A parameter as the user wrote it: "--out" on the command line, "out" in Python."""
    return f"--{name}" if is_on_command_line() else name


def unknown_name(what: str, name: str, known: Iterable[str]) -> InputError:
    """The error for an unregistered name, with the nearest known name as a suggestion."""
    names = sorted(known)
    near = get_close_matches(name, names, n=1, cutoff=0.5)
    remedy = f"did you mean '{near[0]}'?" if near else f"known: {shorten(', '.join(names), MOST_NAMES_LENGTH)}"
    return InputError(f"unknown {what} '{name}': {remedy}")


def wrong_value(message: str, value: object) -> str:
    """pydantic's "Input should be X" as "expected X, got VALUE"."""
    wanted = message.removeprefix("Input should be ")
    expected = f"expected: {message}" if wanted == message else f"expected {wanted}"
    return f"{expected}, got {shown(value)}"


def shown(value: object) -> str:
    """A value as at most 60 characters of a line."""
    text = " ".join(line.strip() for line in repr(value).splitlines())
    return text if len(text) <= 60 else f"{text[:57]}..."


def refuse_unknown(given: Mapping[str, Any], make: Callable[..., Any]) -> None:
    """InputError for arguments by other names than those of `make`."""
    parameters = signature(make).parameters.values()
    for name in given:
        raise unknown_name("option", name, [one.name for one in parameters if one.kind is not Parameter.VAR_KEYWORD])


def refuse_options(options: Any) -> None:
    """InputError for `options` of a reset: the environments have none."""
    if options is not None and options != {}:
        raise InputError(f"reset: options: expected none, got {shown(options)}")


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
