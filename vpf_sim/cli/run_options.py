"""The options of every command that drives many episodes into a run folder."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any

from vpf_sim.api.execution import Execution
from vpf_sim.cli.options import (
    ClusterOption,
    JsonOption,
    MixedOption,
    OutOption,
    ResumeOption,
    SeedsOption,
    TimeoutOption,
    WorkersOption,
)

OPTIONS: dict[str, Any] = {
    "seeds": SeedsOption,
    "workers": WorkersOption,
    "timeout": TimeoutOption,
    "cluster": ClusterOption,
    "out": OutOption,
    "resume": ResumeOption,
    "mixed": MixedOption,
    "json": JsonOption,
}


@dataclass(frozen=True, slots=True)
class RunOptions(Execution):
    """Which seeds are driven, how, and whether the answer is JSON; each field is an option."""

    seeds: str | None = None
    json: bool = False


def with_run_options(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the fields of RunOptions as options; it receives them as its first argument.

    typer reads options from a function's signature, so the returned function has a signature with all of them.
    """
    _, *own = signature(command).parameters.values()
    defaults = {one.name: one.default for one in fields(RunOptions)}
    shared = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=defaults[name], annotation=option)
        for name, option in OPTIONS.items()
    ]

    @wraps(command)
    def wrapper(**given: Any) -> None:
        run = RunOptions(**{name: given.pop(name) for name in OPTIONS})
        command(run, **given)

    wrapper.__signature__ = Signature([*own, *shared])  # type: ignore[attr-defined]
    wrapper.__annotations__ = {one.name: one.annotation for one in (*own, *shared)}
    return wrapper
