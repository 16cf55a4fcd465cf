"""The options of every command that drives many episodes into a run folder."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Any

from vpf_sim import shell
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
from vpf_sim.errors import InputError


@dataclass(frozen=True, slots=True)
class RunOptions:
    """Which seeds are driven, by which workers, into which folder; each field is an option."""

    seeds: SeedsOption = None
    workers: WorkersOption = None
    timeout: TimeoutOption = None
    cluster: ClusterOption = None
    out: OutOption = None
    resume: ResumeOption = False
    mixed: MixedOption = False
    json: JsonOption = False

    def check(self) -> None:
        """InputError where options contradict each other."""
        if self.resume and self.out is None:
            raise InputError("--resume: expected the folder of the run in --out, got none")
        if self.resume and self.out is not None and not self.out.exists():
            raise InputError(f"{self.out}: --resume: expected the folder of a run, found nothing")
        if self.cluster is not None and self.workers is not None:
            raise InputError("--workers: expected --workers or --cluster, got both; the cluster has its own workers")

    def resume_command(self, command: str, folder: Path) -> str:
        """The shell command that continues the run."""
        return shell.command(
            command,
            out=folder,
            resume=True,
            workers=self.workers,
            cluster=self.cluster,
            timeout=self.timeout,
            mixed=self.mixed,
        )


def with_run_options(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the fields of RunOptions as options; it receives them as its first argument.

    typer reads options from a function's signature, so the returned function has a signature with all of them.
    """
    _, *own = signature(command).parameters.values()
    shared = [
        Parameter(one.name, Parameter.KEYWORD_ONLY, default=one.default, annotation=one.type)
        for one in fields(RunOptions)
    ]

    @wraps(command)
    def wrapper(**given: Any) -> None:
        run = RunOptions(**{one.name: given.pop(one.name) for one in shared})
        command(run, **given)

    wrapper.__signature__ = Signature([*own, *shared])  # type: ignore[attr-defined]
    wrapper.__annotations__ = {one.name: one.annotation for one in (*own, *shared)}
    return wrapper
