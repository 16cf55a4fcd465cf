"""Errors of the user, one line each."""

from collections.abc import Iterable
from difflib import get_close_matches


class InputError(Exception):
    """Wrong use or wrong input; the command line prints the message and exits with 2."""


def unknown_name(what: str, name: str, known: Iterable[str]) -> InputError:
    """The error for an unregistered name, with the nearest known name as a suggestion."""
    names = sorted(known)
    near = get_close_matches(name, names, n=1, cutoff=0.5)
    remedy = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names)}"
    return InputError(f"unknown {what} '{name}': {remedy}")


def wrong_value(message: str, value: object) -> str:
    """pydantic's "Input should be X" as "expected X, got VALUE"."""
    wanted = message.removeprefix("Input should be ")
    expected = f"expected: {message}" if wanted == message else f"expected {wanted}"
    return f"{expected}, got {shown(value)}"


def shown(value: object) -> str:
    """A value as at most 60 characters of a line."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
