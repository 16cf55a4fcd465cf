"""`vpf-sim benchmark`: the paper's simulator table, measured beside the printed values."""

from typing import Annotated

import typer

from vpf_sim.cli.options import DriversOption, print_json, prints_on_stderr
from vpf_sim.cli.run_options import RunOptions, fill, plan_of, with_run_options
from vpf_sim.shell import command

ReportOption = Annotated[bool, typer.Option("--report/--no-report", help="Write report.html, with videos of failures.")]


@with_run_options
def benchmark(run: RunOptions, driver: DriversOption = None, report: ReportOption = True) -> None:
    """Measure the paper's table: Town04 in clear weather and rain.

    It is driven without and with obstacles, by the paper's method, ours and the PID.
    """
    from vpf_sim.api.report import report as write_report
    from vpf_sim.cli.results import exit_code, print_benchmark, stored_summary
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
