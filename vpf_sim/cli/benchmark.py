"""`vpf-sim benchmark`: the paper's simulator table, measured beside the printed values."""

from collections.abc import Sequence
from typing import Annotated

import typer

from vpf_sim.cli.options import DriversOption, print_json, prints_on_stderr
from vpf_sim.cli.results import driver_name
from vpf_sim.cli.run_options import RunOptions, fill, plan_of, with_run_options
from vpf_sim.cli.tables import number, percent, print_table
from vpf_sim.evaluation.analysis.rows import Row
from vpf_sim.evaluation.metrics.registry import LEAST_CLEARANCE, PATH_MSE, STEERING, THROTTLE
from vpf_sim.shell import command

ReportOption = Annotated[bool, typer.Option("--report/--no-report", help="Write report.html, with videos of failures.")]


@with_run_options
def benchmark(run: RunOptions, driver: DriversOption = None, report: ReportOption = True) -> None:
    """Measure the paper's table: Town04 in clear weather and rain.

    It is driven without and with obstacles, by the paper's method, ours and the PID.
    """
    from vpf_sim.api.report import report as write_report
    from vpf_sim.cli.results import exit_code, stored_summary
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


HEADER = ("scenario", "weather", "driver", "success", "MSE, m2", "throttle, %", "steering, %", "clearance, m")


def print_benchmark(rows: Sequence[Row], seeds: str) -> None:
    """Print a row for each scenario, weather and driver, and how to read them."""
    ordered = sorted(rows, key=_place)
    print_table(HEADER, [_cells(row) for row in ordered], words=3)
    print(f"\nSeeds {seeds}: {_answer(ordered[0].driver, rows)}.")
    print("After the slash: the paper, which does not define accuracy; ours is 1 - mean |u - u_PID| / 2.")


def _answer(driver: str, rows: Sequence[Row]) -> str:
    """How often a driver succeeded in all cells, and its least clearance."""
    own = [row for row in rows if row.driver == driver]
    gaps = [gap for row in own if (gap := row[LEAST_CLEARANCE]) is not None]
    successes, episodes = sum(row.successes for row in own), sum(row.episodes for row in own)
    passed = f", at least {min(gaps):.2f} m from parked cars" if gaps else ""
    return f"{driver} reached the goal in {successes} of {episodes} drives{passed}"


def _place(row: Row) -> tuple[int, int, int, str]:
    """Sort key: scenarios, weathers and drivers in the benchmark's order, then a user's drivers."""
    from vpf_sim.evaluation.analysis.benchmark import DRIVERS, SCENARIOS, WEATHERS

    driver = DRIVERS.index(row.driver) if row.driver in DRIVERS else len(DRIVERS)
    return SCENARIOS.index(row.scenario), WEATHERS.index(row.weather), driver, row.driver


def _cells(row: Row) -> tuple[str, ...]:
    """Means over the successful episodes, each beside the paper's value; a dash without success."""
    paper, scores = row.paper or {}, row.scores if row.successes else {}
    accuracies = [
        f"{percent(scores.get(metric.key))} / {percent(paper.get(metric.paper))}" for metric in (THROTTLE, STEERING)
    ]
    return (
        row.scenario,
        row.weather,
        driver_name(row),
        f"{row.successes}/{row.episodes}",
        f"{number(scores.get(PATH_MSE.key), PATH_MSE.digits)} / {number(paper.get(PATH_MSE.paper))}",
        *accuracies,
        number(row[LEAST_CLEARANCE]),
    )
