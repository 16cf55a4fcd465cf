"""The options of every command that drives many episodes into a run folder."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vpf_sim.api.filling import Execution
from vpf_sim.cli.options import (
    ClusterOption,
    JsonOption,
    MixedOption,
    OutOption,
    ResumeOption,
    SeedsOption,
    TimeoutOption,
    WorkersOption,
    prints_on_stderr,
)
from vpf_sim.errors import InputError

if TYPE_CHECKING:
    from vpf_sim.evaluation.sweeps.plan import Plan


OPTIONS: dict[str, object] = {
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
    """Which seeds are driven, how, and whether the output is JSON; each field is an option."""

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


def plan_of(run: RunOptions, requested: bool, make: "Callable[[], Plan]") -> "Plan":
    """The plan that `make` returns, or the stored one where a run is resumed and nothing else was given."""
    from vpf_sim.evaluation.run_inputs import RunInputs
    from vpf_sim.evaluation.sweeps.manifest import MANIFEST, read_manifest, stored_plan
    from vpf_sim.evaluation.sweeps.plan import parse_seeds

    if run.seeds is not None:
        parse_seeds(run.seeds)
    if not run.resume or requested or run.out is None or not run.out.exists():
        return make()
    if not (run.out / MANIFEST).exists():
        raise InputError(f"{run.out}: --resume: expected the {MANIFEST} of a run, found none; name what to drive")
    stored = read_manifest(run.out)
    RunInputs.of(run.out, stored.made_in).check_here("--resume", stored.names("driver"))
    return stored_plan(run.out)


def fill(command: str, plan: "Plan", run: Execution) -> Path:
    """Drive the missing episodes of a plan, write the summary, and return the run folder."""
    from vpf_sim.api import filling

    with prints_on_stderr():
        return filling.fill(command, plan, run)
