"""`vpf-sim readings`: search readings of the paper under which its control law reproduces its table."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vpf_sim.cli.options import (
    ClusterOption,
    JsonOption,
    OutOption,
    ResumeOption,
    SeedsOption,
    TimeoutOption,
    WorkersOption,
    print_json,
)

if TYPE_CHECKING:
    from vpf_sim.evaluation.readings.search import Record, Trial
    from vpf_sim.evaluation.sweeps.plan import Plan

NAME = "readings.json"
ReadingsOption = Annotated[int, typer.Option("--readings", metavar="N", min=1, help="Number of readings to try.")]
FinalistsOption = Annotated[
    int, typer.Option("--finalists", metavar="N", min=1, help="Number of best readings that drive more seeds.")
]
FinalSeedsOption = Annotated[str, typer.Option("--final-seeds", metavar="A:B", help="Seeds of the finalists.")]
OptimiserSeedOption = Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the optimiser.")]
ListOption = Annotated[bool, typer.Option("--list", help="List the quantities and their readings without driving.")]


def readings(
    readings: ReadingsOption = 200,
    seeds: SeedsOption = None,
    finalists: FinalistsOption = 4,
    final_seeds: FinalSeedsOption = "10:20",
    seed: OptimiserSeedOption = 0,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
    cluster: ClusterOption = None,
    out: OutOption = None,
    resume: ResumeOption = False,
    show: ListOption = False,
    json: JsonOption = False,
) -> None:
    """Search readings of the paper that reproduce its table.

    They are values of what the paper leaves open. Each drives its four cells, the best drive more seeds.
    """
    from vpf_sim.api.execution import Execution
    from vpf_sim.cli.running import fill
    from vpf_sim.errors import InputError
    from vpf_sim.evaluation.readings.outcome import by_choice
    from vpf_sim.evaluation.readings.search import SearchSettings, Tpe, finals, search
    from vpf_sim.evaluation.readings.space import known, quantities
    from vpf_sim.evaluation.sweeps.run_folder import new_path, read_records, write_json

    space = quantities()
    if show:
        rows = [asdict(quantity) for quantity in space]
        print_json({"quantities": rows}) if json else _print_space(rows)
        return
    settings = SearchSettings(readings, seeds=seeds or "0:1", finalists=finalists, final_seeds=final_seeds, seed=seed)
    optimiser = Tpe(space, settings.seed, known())
    Execution(out=out, resume=resume).check_folder()
    if out is not None and out.exists() and not resume:
        raise InputError(f"{out}: expected a new folder, or --resume to continue the search in it")
    folder = out or new_path("readings")

    def drive(plan: "Plan", path: Path) -> "Sequence[Record]":
        how = Execution(workers, timeout, cluster, path, resume=path.exists())
        return read_records(fill("readings", plan, how))

    trials = search(settings, folder, drive, optimiser)
    best = finals(settings, trials, folder, drive)
    choices = by_choice(space, trials)
    answer = {
        "asked": asdict(settings),
        "tried": [asdict(one) for one in trials],
        "finals": [asdict(one) for one in best],
        "choices": choices,
    }
    write_json(folder / NAME, answer)
    if json:
        print_json({"out": str(folder), **answer})
    else:
        _print_choices(choices)
        _print_finals(best, settings.final_seeds)
        print(f"\nall readings and their scores: {folder / NAME}")
        print(f"the best as a variant: {best[0].driver.partition('@')[2]}")


def _print_space(rows: list[dict[str, Any]]) -> None:
    from vpf_sim.cli.tables import print_table

    lines = [
        (quantity["name"], choice or f"{quantity['low']:g} to {quantity['high']:g}", source)
        for quantity in rows
        for choice, source in quantity["sources"].items()
    ]
    print_table(("quantity", "reading", "source"), lines, words=3)


def _print_choices(rows: list[dict[str, Any]]) -> None:
    from vpf_sim.cli.tables import number, print_table

    lines = [
        (row["quantity"], row["choice"], str(row["tried"]), *map(str, row["passed"]), number(row["best_score"]))
        for row in rows
    ]
    print_table(("quantity", "reading", "tried", "passed 1", "2", "3", "4 cells", "best score"), lines, words=2)


def _print_finals(best: "Sequence[Trial]", seeds: str) -> None:
    from vpf_sim.cli.tables import number, print_table

    print(f"\nThe best on the seeds {seeds}:\n")
    lines = [
        (f"{one.number}", cell, f"{result['successes']}/{result['episodes']}", number(result["path_mse_m2"]))
        for one in best
        for cell, result in one.cells.items()
    ]
    print_table(("reading", "cell", "success", "MSE m2"), lines, words=2)
