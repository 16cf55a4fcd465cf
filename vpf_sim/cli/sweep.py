"""`vpf-sim sweep`: a grid of scenarios, weathers, drivers and seeds."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from vpf_sim.cli.options import DriversOption, ScenariosOption, WeathersOption, print_json, prints_on_stderr
from vpf_sim.cli.run_options import RunOptions, fill, plan_of, with_run_options
from vpf_sim.cli.tables import print_table
from vpf_sim.shell import command

if TYPE_CHECKING:
    from vpf_sim.evaluation.sweeps.plan import Plan


FileArgument = Annotated[
    str | None,
    typer.Argument(
        metavar="FILE",
        help="A sweep file, hard (99 hard episodes) or ablation (from vpf-paper to vpf); options override it.",
    ),
]
DryRunOption = Annotated[bool, typer.Option("--dry-run", help="Show what would be driven; drive and write nothing.")]
DEFAULTS: dict[str, Any] = {"scenario": ["town04"], "weather": ["clear"], "driver": ["vpf"], "seeds": "0:5"}


@with_run_options
def sweep(
    run: RunOptions,
    file: FileArgument = None,
    scenario: ScenariosOption = None,
    weather: WeathersOption = None,
    driver: DriversOption = None,
    dry_run: DryRunOption = False,
) -> None:
    """Drive a grid of episodes.

    With --resume alone, the grid is the one stored in the folder.
    """
    from vpf_sim.cli.results import exit_code, print_comparisons, print_rows, stored_summary
    from vpf_sim.evaluation.sweeps.plan import Plan, make_plan, read_plan

    given = {"scenario": scenario, "weather": weather, "driver": driver, "seeds": run.seeds}
    given = {key: value for key, value in given.items() if value}

    def make() -> Plan:
        from_file = read_plan(file) if file else {}
        defaults = {"driver": DEFAULTS["driver"]} if "drives" in from_file else DEFAULTS
        return make_plan({**defaults, **from_file, **given}, str(file or "sweep"))

    plan = plan_of(run, bool(given or file), make)
    if dry_run:
        print_plan(plan, run)
        return
    path = fill("sweep", plan, run)
    summary = stored_summary(path)
    if run.json:
        print_json({"out": str(path), **summary.as_json()})
    else:
        print_rows(summary.rows)
        print_comparisons(summary.comparisons)
        print(f"\nrecords and steps: {path}")
        print(f"as a page: {command('report', path)}")
    raise typer.Exit(exit_code(summary))


def print_plan(plan: "Plan", run: RunOptions) -> None:
    """Check a plan as a sweep would, and print its cells and episodes without driving or writing."""
    from vpf_sim.evaluation.sweeps.manifest import Manifest
    from vpf_sim.evaluation.sweeps.run_folder import admitted, read_records
    from vpf_sim.evaluation.sweeps.seeds import seeds_text

    run.check(plan)
    with prints_on_stderr():
        asked = Manifest.of("sweep", plan)
    done: set[str] = set()
    if run.out is not None:
        admitted(run.out, asked, run.resume, run.mixed)
        done = {record.id for record in read_records(run.out)} if run.resume else set()
    cells: dict[tuple[str, str, str], list[int]] = {}
    for job in plan.jobs():
        if job.id not in done:
            cells.setdefault((job.scenario, job.weather, job.driver), []).append(job.seed)
    episodes = sum(map(len, cells.values()))
    if run.json:
        keys = ("scenario", "weather", "driver", "seeds")
        rows = [dict(zip(keys, (*cell, seeds), strict=True)) for cell, seeds in cells.items()]
        print_json({"episodes": episodes, "stored": len(done), "cells": rows})
        return
    lines = [(*cell, str(len(seeds)), seeds_text(seeds, "--seeds")) for cell, seeds in cells.items()]
    print_table(("scenario", "weather", "driver", "episodes", "seeds"), lines, words=3)
    stored = f", {len(done)} are stored" if run.resume else ""
    to_drive = f"{_counted(episodes, 'episode')} to drive in {_counted(len(cells), 'cell')}"
    print(f"\n{to_drive}{stored}; nothing was driven or written")


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" + "s" * (count != 1)
