"""`vpf-sim reproduce`: the paper's simulator experiment by its own law, held against what the paper prints."""

import typer

from vpf_sim.cli.options import (
    ClusterOption,
    DriverOption,
    JsonOption,
    MixedOption,
    OutOption,
    ResumeOption,
    SeedsOption,
    TimeoutOption,
    WorkersOption,
    print_json,
)


def reproduce(
    seeds: SeedsOption = None,
    driver: DriverOption = "vpf-paper",
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
    cluster: ClusterOption = None,
    out: OutOption = None,
    resume: ResumeOption = False,
    mixed: MixedOption = False,
    json: JsonOption = False,
) -> None:
    """Drive the paper's four conditions by its own law: table, claims and figures beside the paper's."""
    from vpf_sim.cli.options import prints_on_stderr
    from vpf_sim.cli.results import exit_code, read_summary
    from vpf_sim.cli.running import Means, fill, plan_of
    from vpf_sim.cli.tables import number, print_table
    from vpf_sim.evaluation.analysis import reproduction
    from vpf_sim.evaluation.sweeps.plan import parse_seeds
    from vpf_sim.report import paper_page
    from vpf_sim.report.stored_run import open_run

    if seeds is not None:
        parse_seeds(seeds)
    plan = plan_of(out, resume, bool(seeds), lambda: reproduction.plan(seeds, driver))
    path = fill("reproduce", plan, Means(out, resume, mixed, workers, timeout, cluster))
    run, tested = open_run(path), plan.driver[0]
    drives = paper_page.drives_of(run, tested)
    found = paper_page.answer(run, tested, drives)
    with prints_on_stderr():
        page = paper_page.write(path, drives, found)
    if json:
        print_json({"out": str(path), "seeds": plan.seeds, **found})
    else:
        lines = [
            (
                f"{row['weather']}, {row['scenario']}",
                f"{row['successes']} of {row['episodes']}",
                number(row["paper"]["path_mse_m2"]),
                number(row["path_mse_m2"].get("lane centre")),
                number(row["clearance_m"]),
            )
            for row in found["cells"]
        ]
        print(f"{tested} on the paper's road, seeds {plan.seeds}:\n")
        print_table(("condition", "reached", "paper's MSE m2", "MSE m2", "clearance m"), lines)
        print("\nThe paper's claims:\n")
        told = {True: "holds", False: "does not hold", None: "cannot be told"}
        for row in found["claims"]:
            print(f"  {told[row['holds']]}: {row['claim']}\n      {row['measured']}")
        print(f"\ntable, claims and figures: {page}")
    raise typer.Exit(exit_code(read_summary(path)))
