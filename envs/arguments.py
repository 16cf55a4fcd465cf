"""Arguments of the environments that mean nothing to them: refused, since a mistyped one would be without effect."""

from collections.abc import Callable, Mapping
from inspect import Parameter, signature
from typing import Any

from vpf_sim.errors import InputError, shown, unknown_name


def refuse_unknown(given: Mapping[str, Any], make: Callable[..., Any]) -> None:
    """InputError for arguments by other names than those of `make`."""
    parameters = signature(make).parameters.values()
    for name in given:
        raise unknown_name("option", name, [one.name for one in parameters if one.kind is not Parameter.VAR_KEYWORD])


def refuse_options(options: Any) -> None:
    """InputError for `options` of a reset: the environments have none."""
    if options is not None and options != {}:
        raise InputError(f"reset: options: expected none, got {shown(options)}")
