"""Fill a run folder as a command does: prints of drivers go to stderr."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim.cli.options import prints_on_stderr
from vpf_sim.cli.run_options import RunOptions
from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.seeds import parse_seeds

if TYPE_CHECKING:
    from vpf_sim.api.execution import Execution


def plan_of(run: RunOptions, asked: bool, make: Callable[[], Plan]) -> Plan:
    """The plan that `make` returns, or the stored one where a run is resumed and nothing else was asked."""
    from vpf_sim.evaluation.run_inputs import RunInputs
    from vpf_sim.evaluation.sweeps.run_folder import MANIFEST, read_manifest, stored_plan

    if run.seeds is not None:
        parse_seeds(run.seeds)
    if not run.resume or asked or run.out is None or not run.out.exists():
        return make()
    if not (run.out / MANIFEST).exists():
        raise InputError(f"{run.out}: --resume: expected the {MANIFEST} of a run, found none; name what to drive")
    RunInputs.of(run.out, read_manifest(run.out)).check_here("--resume")
    return stored_plan(run.out)


def fill(command: str, plan: Plan, run: "Execution") -> Path:
    """Drive the missing episodes of a plan, write the summary, and return the run folder."""
    from vpf_sim.api import filling

    with prints_on_stderr():
        return filling.fill(command, plan, run)
