"""Commands that drive many episodes: `vpf-sim sweep`, `benchmark` and `reproduce`."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import (
    DriverOption,
    DriversOption,
    ScenariosOption,
    WeathersOption,
    print_json,
    prints_on_stderr,
)
from vpf_sim.cli.output import print_table
from vpf_sim.cli.run_options import RunOptions, fill, plan_of, with_run_options
from vpf_sim.system import command

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
DEFAULTS: dict[str, list[str] | str] = {"scenario": ["town04"], "weather": ["clear"], "driver": ["vpf"], "seeds": "0:5"}
ReportOption = Annotated[bool, typer.Option("--report/--no-report", help="Write report.html, with videos of failures.")]
if TYPE_CHECKING:
    from vpf_sim.reporting.paper_page import Findings


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
    from vpf_sim.cli.sweep_tables import exit_code, print_comparisons, print_rows, stored_summary
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
    from vpf_sim.evaluation.sweeps.plan import seeds_text
    from vpf_sim.evaluation.sweeps.run_folder import admitted, read_records

    run.check(plan)
    with prints_on_stderr():
        requested = Manifest.of("sweep", plan)
    done: set[str] = set()
    if run.out is not None:
        admitted(run.out, requested, run.resume, run.mixed)
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


@with_run_options
def benchmark(run: RunOptions, driver: DriversOption = None, report: ReportOption = True) -> None:
    """Measure the paper's table: Town04 in clear weather and rain.

    It is driven without and with obstacles, by the paper's method, ours and the PID.
    """
    from vpf_sim.api.report import report as write_report
    from vpf_sim.cli.sweep_tables import exit_code, print_benchmark, stored_summary
    from vpf_sim.evaluation.analysis.benchmark import plan as benchmark_plan

    plan = plan_of(run, bool(run.seeds or driver), lambda: benchmark_plan(run.seeds, driver or []))
    path = fill("benchmark", plan, run)
    summary = stored_summary(path)
    with prints_on_stderr():
        page = write_report(path).page if report else None
    if run.json:
        print_json({"out": str(path), "seeds": plan.seeds, **summary.as_json()})
    else:
        print_benchmark(summary.rows, plan.seeds)
        print(f"All definitions, intervals and differences: {page or command('report', path)}")
    raise typer.Exit(exit_code(summary))


@with_run_options
def reproduce(run: RunOptions, driver: DriverOption = "vpf-paper") -> None:
    """Repeat the paper's experiment with its own control law.

    Its four conditions are driven; table, claims and figures are compared with the paper's.
    """
    from vpf_sim.cli.options import prints_on_stderr
    from vpf_sim.cli.run_options import fill, plan_of
    from vpf_sim.cli.sweep_tables import exit_code, stored_summary
    from vpf_sim.evaluation.analysis import reproduction
    from vpf_sim.reporting import paper_page
    from vpf_sim.reporting.run_data import open_run

    plan = plan_of(run, bool(run.seeds), lambda: reproduction.plan(run.seeds, driver))
    path = fill("reproduce", plan, run)
    stored, tested = open_run(path), plan.driver[0]
    drives = paper_page.drives_of(stored, tested)
    found = paper_page.findings(stored, tested, drives)
    with prints_on_stderr():
        page = paper_page.write(path, drives, found)
    if run.json:
        print_json({"out": str(path), "seeds": plan.seeds, **asdict(found)})
    else:
        print(f"{tested} on the paper's road, seeds {plan.seeds}:\n")
        _print_paper(found)
        print(f"\ntable, claims and figures: {page}")
    raise typer.Exit(exit_code(stored_summary(path)))


def _print_paper(found: "Findings") -> None:
    """The table, then the claims."""
    from vpf_sim.cli.output import number, print_table

    lines = [
        (
            f"{row.weather}, {row.scenario}",
            f"{row.successes} of {row.episodes}",
            *map(number, (row.paper["path_mse_m2"], row.lane_mse_m2, row.clearance_m)),
        )
        for row in found.cells
    ]
    print_table(("condition", "reached", "paper's MSE m2", "MSE m2", "clearance m"), lines)
    print("\nThe paper's claims:\n")
    for one in found.claims:
        print(f"  {one.verdict}: {one.claim}\n      {one.measured}")
