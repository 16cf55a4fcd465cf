"""`vpf-sim sweep`: a grid of scenarios, weathers, drivers and seeds."""

from typing import Annotated, Any

import typer

from vpf_sim.cli.options import DriversOption, ScenariosOption, WeathersOption, print_json
from vpf_sim.cli.run_options import RunOptions, with_run_options
from vpf_sim.shell import command

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
    from vpf_sim.cli.dry_run import print_plan
    from vpf_sim.cli.results import exit_code, print_comparisons, print_rows, read_summary
    from vpf_sim.cli.running import fill, plan_of
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
    summary = read_summary(path)
    if run.json:
        print_json({"out": str(path), **summary})
    else:
        print_rows(summary["rows"])
        print_comparisons(summary["comparisons"])
        print(f"\nrecords and steps: {path}")
        print(f"as a page: {command('report', path)}")
    raise typer.Exit(exit_code(summary))
