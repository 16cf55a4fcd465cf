"""`vpf-sim reproduce`: the paper's simulator experiment with its own control law, compared with the printed results."""

from dataclasses import asdict
from typing import TYPE_CHECKING

import typer

from vpf_sim.cli.options import DriverOption, print_json
from vpf_sim.cli.run_options import RunOptions, with_run_options

if TYPE_CHECKING:
    from vpf_sim.reporting.paper_page import Answer


@with_run_options
def reproduce(run: RunOptions, driver: DriverOption = "vpf-paper") -> None:
    """Repeat the paper's experiment with its own control law.

    Its four conditions are driven; table, claims and figures are compared with the paper's.
    """
    from vpf_sim.cli.options import prints_on_stderr
    from vpf_sim.cli.results import exit_code, stored_summary
    from vpf_sim.cli.run_options import fill, plan_of
    from vpf_sim.evaluation.analysis import reproduction
    from vpf_sim.reporting import paper_page
    from vpf_sim.reporting.stored_run import open_run

    plan = plan_of(run, bool(run.seeds), lambda: reproduction.plan(run.seeds, driver))
    path = fill("reproduce", plan, run)
    stored, tested = open_run(path), plan.driver[0]
    drives = paper_page.drives_of(stored, tested)
    found = paper_page.answer(stored, tested, drives)
    with prints_on_stderr():
        page = paper_page.write(path, drives, found)
    if run.json:
        print_json({"out": str(path), "seeds": plan.seeds, **asdict(found)})
    else:
        print(f"{tested} on the paper's road, seeds {plan.seeds}:\n")
        _print(found)
        print(f"\ntable, claims and figures: {page}")
    raise typer.Exit(exit_code(stored_summary(path)))


def _print(found: "Answer") -> None:
    """The table, then the claims."""
    from vpf_sim.cli.tables import number, print_table

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
