"""`vpf-sim sweep`: a grid of scenarios, weathers, drivers and seeds."""

from pathlib import Path
from typing import Annotated, Any

import typer

from vpf_sim.cli.options import (
    ClusterOption,
    DriversOption,
    JsonOption,
    MixedOption,
    OutOption,
    ResumeOption,
    ScenariosOption,
    SeedsOption,
    TimeoutOption,
    WeathersOption,
    WorkersOption,
    print_json,
)
from vpf_sim.shell import command

FileArgument = Annotated[Path | None, typer.Argument(metavar="FILE", help="A sweep file; options win over it.")]
DEFAULTS: dict[str, Any] = {"scenario": ["town04"], "weather": ["clear"], "driver": ["vpf"], "seeds": "0:5"}


def sweep(
    file: FileArgument = None,
    scenario: ScenariosOption = None,
    weather: WeathersOption = None,
    driver: DriversOption = None,
    seeds: SeedsOption = None,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
    cluster: ClusterOption = None,
    out: OutOption = None,
    resume: ResumeOption = False,
    mixed: MixedOption = False,
    json: JsonOption = False,
) -> None:
    """Drive the grid. With --resume and nothing else asked, the grid that the folder was made for."""
    from vpf_sim.cli.results import exit_code, print_comparisons, print_rows, read_summary
    from vpf_sim.cli.running import Means, fill, plan_of
    from vpf_sim.evaluation.sweeps.plan import Plan, make_plan, parse_seeds, read_plan

    given = {"scenario": scenario, "weather": weather, "driver": driver, "seeds": seeds}
    given = {key: value for key, value in given.items() if value}
    if seeds is not None:
        parse_seeds(seeds)

    def make() -> Plan:
        told = read_plan(file) if file else {}
        defaults = {"driver": DEFAULTS["driver"]} if "drives" in told else DEFAULTS
        return make_plan({**defaults, **told, **given}, str(file or "sweep"))

    plan = plan_of(out, resume, bool(given or file), make)
    path = fill("sweep", plan, Means(out, resume, mixed, workers, timeout, cluster))
    summary = read_summary(path)
    if json:
        print_json({"out": str(path), **summary})
    else:
        print_rows(summary["rows"])
        print_comparisons(summary["comparisons"])
        print(f"\nrecords and steps: {path}")
        print(f"a page of all this: {command('report', path)}")
    raise typer.Exit(exit_code(summary))
