"""`vpf-sim verify`: whether a run folder is what it says."""

import secrets
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.api.progress import say
from vpf_sim.cli.options import JsonOption, RunArgument, WorkersOption, print_json, prints_on_stderr
from vpf_sim.errors import InputError

if TYPE_CHECKING:
    from vpf_sim.evaluation.job import Job
    from vpf_sim.evaluation.verification.mismatch import Mismatch
    from vpf_sim.evaluation.verification.run import Run

MOST_SEED = 2**32
ShareOption = Annotated[
    float, typer.Option("--share", metavar="S", help="Share of the episodes that are driven again, 0 to 1.")
]
SeedOption = Annotated[
    int | None, typer.Option("--seed", metavar="N", min=0, help="Which episodes; by default others each time.")
]


def verify(
    run: RunArgument,
    share: ShareOption = 0.05,
    seed: SeedOption = None,
    workers: WorkersOption = None,
    json: JsonOption = False,
) -> None:
    """Check a run against its steps, and drive some of it again.

    Each planned episode must have a record, whose scores follow from its steps.

    Exit code 1 with the first difference.
    """
    from vpf_sim.evaluation.verification import again, claims
    from vpf_sim.evaluation.verification.run import Run

    if not 0.0 <= share <= 1.0:
        raise InputError(f"--share: expected 0 to 1, got {share:g}")
    seed = secrets.randbelow(MOST_SEED) if seed is None else seed
    with prints_on_stderr():
        stored = Run.of(run)
        chosen = again.sample(stored.jobs, share, seed) if share > 0.0 else []
        found = next(claims.mismatches(stored, {job.id for job in chosen}), None)
        chosen = [] if found else chosen
        found = found or _first(stored, chosen, workers)
    if json:
        driven = [job.id for job in chosen]
        answer = {"ok": found is None, "planned": len(stored.jobs), "seed": seed, "driven": driven}
        answer |= {"records_sha256": stored.records_sha256}
        print_json({**answer, "mismatch": None if found is None else found.as_json()})
    else:
        _print(stored, chosen, seed, found)
    raise typer.Exit(int(found is not None))


def _first(run: "Run", jobs: "list[Job]", workers: int | None) -> "Mismatch | None":
    """The first difference of the episodes driven again; the others are still driven."""
    from vpf_sim.evaluation.sweeps.sweep import default_workers
    from vpf_sim.evaluation.verification import again

    found: dict[str, Mismatch] = {}
    for number, done in enumerate(again.drive(run, jobs, workers or default_workers()), start=1):
        if done.reason:
            raise InputError(f"{done.task.id}: {done.reason.splitlines()[0]}")
        say(f"{number}/{len(jobs)} {done.task.id} {'equal' if done.result is None else 'differs'}")
        if done.result is not None:
            found[done.task.id] = done.result
    return found[min(found)] if found else None


def _print(run: "Run", jobs: "list[Job]", seed: int, found: "Mismatch | None") -> None:
    if found is not None:
        print(f"NOT VERIFIED: {found}")
        return
    print(f"{run.path}: {len(run.jobs)} planned episodes, all stored; what is stored does not contradict itself")
    if jobs:
        print(f"{len(jobs)} driven again (--seed {seed}): states, commands, frames and scores are equal to the bit")
    print("verified")
