"""`vpf-sim benchmark`: the paper's simulator table, ours beside its cells."""

from typing import Annotated

import typer

from vpf_sim.cli.options import (
    ClusterOption,
    DriversOption,
    JsonOption,
    MixedOption,
    OutOption,
    ResumeOption,
    SeedsOption,
    TimeoutOption,
    WorkersOption,
    print_json,
)

ReportOption = Annotated[bool, typer.Option("--report/--no-report", help="Write report.html, with films of failures.")]


def benchmark(
    seeds: SeedsOption = None,
    driver: DriversOption = None,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
    cluster: ClusterOption = None,
    out: OutOption = None,
    resume: ResumeOption = False,
    mixed: MixedOption = False,
    report: ReportOption = True,
    json: JsonOption = False,
) -> None:
    """Town04 without and with obstacles, clear and in rain: the paper's method in its variants, and the PID."""
    from vpf_sim.cli.report import write as write_report
    from vpf_sim.cli.results import exit_code, print_benchmark, print_comparisons, read_summary
    from vpf_sim.cli.running import Means, fill, plan_of
    from vpf_sim.evaluation.analysis.benchmark import plan as benchmark_plan
    from vpf_sim.evaluation.sweeps.plan import parse_seeds

    if seeds is not None:
        parse_seeds(seeds)
    plan = plan_of(out, resume, bool(seeds or driver), lambda: benchmark_plan(seeds, driver or []))
    path = fill("benchmark", plan, Means(out, resume, mixed, workers, timeout, cluster))
    summary = read_summary(path)
    page = write_report(path) if report else None
    if json:
        print_json({"out": str(path), "seeds": plan.seeds, **summary})
    else:
        print_benchmark(summary["rows"], plan.seeds)
        print_comparisons(summary["comparisons"])
        print(f"\nrecords and steps: {path}")
        if page:
            print(f"report: {page}")
    raise typer.Exit(exit_code(summary))
