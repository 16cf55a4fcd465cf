"""The tables of sweeps on the terminal."""

import json
from collections.abc import Sequence
from pathlib import Path

from vpf_sim.api.progress import FAULTS
from vpf_sim.cli.output import number, percent, plain_unit, print_table, shown, within
from vpf_sim.evaluation.analysis.rows import Comparison, Row, Summary, read_summary
from vpf_sim.evaluation.analysis.statistics import Difference
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.registry import DRIVING_SCORE, LEAST_CLEARANCE, PATH_MSE, STEERING, SUCCESS, THROTTLE
from vpf_sim.reporting.main_table import shown as short

COLUMNS = {  # what a screen has room for
    f"MSE {plain_unit(PATH_MSE)}": PATH_MSE,
    f"clearance {LEAST_CLEARANCE.unit}": LEAST_CLEARANCE,
    "throttle %": THROTTLE,
    "steering %": STEERING,
    "driving score": DRIVING_SCORE,
}


def stored_summary(path: Path) -> Summary:
    """The summary of a finished run."""
    return read_summary(json.loads((path / "summary.json").read_bytes()), str(path / "summary.json"))


def exit_code(summary: Summary) -> int:
    """1 if any episode ended by a fault of the harness or the driver's code; a collision is a result."""
    return int(any(fault in row.statuses for row in summary.rows for fault in FAULTS))


def print_rows(rows: Sequence[Row]) -> None:
    """Print a sweep's table."""
    header = ("scenario", "weather", "driver", "success", *COLUMNS)
    print_table(header, [(short(row.scenario), short(row.weather), *_cells(row)) for row in rows], words=3)
    print(
        "\nMSE, throttle and steering (likeness to the PID in the same states): of drives that arrived. Driving score:"
    )
    print("CARLA Leaderboard 2.1's, the route driven less collisions and leaving the road, 0 to 1. 95 % intervals.")


def print_comparisons(comparisons: Sequence[Comparison]) -> None:
    """Print paired differences between weathers and drivers, if there are any."""
    if not comparisons:
        return
    print("\nDifferences on the same seeds, with 95 % intervals and p of no difference:\n")
    header = ("scenario", "weather", "driver", "success", "p", "seeds", "MSE m2", "p", "seeds")
    lines = [
        (
            *_sides(one),
            *_difference(one.differences.get(SUCCESS.key), 2),
            *_difference(one.differences.get(PATH_MSE.key), 3),
        )
        for one in comparisons
    ]
    print_table(header, lines, words=3)
    print("\nSuccess over the planned seeds (McNemar's test), MSE where both succeeded (sign flips). Of many p values,")
    print("some are small by chance.")


def _sides(one: Comparison) -> tuple[str, str, str]:
    """The compared cells, such as "rain - clear" or "vpf - pid"."""
    names = {"scenario": short(one.cell.scenario), "weather": short(one.cell.weather), "driver": one.cell.driver}
    names[one.of] += f" - {short(one.minus)}"
    return names["scenario"], names["weather"], names["driver"]


def _difference(found: Difference | None, digits: int) -> tuple[str, str, str]:
    if found is None:
        return "-", "-", "0"
    return within(found.difference, found.interval, digits), number(found.p, 3), str(found.pairs)


def driver_name(row: Row) -> str:
    """The driver with its privilege, if any."""
    return row.driver if row.privileged == "none" else f"{row.driver} [{row.privileged}]"


def _cells(row: Row) -> tuple[str, ...]:
    return driver_name(row), f"{row.successes}/{row.episodes}", *(_cell(row, metric) for metric in COLUMNS.values())


def _cell(row: Row, metric: Metric) -> str:
    """The mean with its interval; figures of drives that arrived have none without such a drive."""
    return shown(metric, row[metric], row.interval(metric))


BENCHMARK = ("scenario", "weather", "driver", "success", "MSE, m2", "throttle, %", "steering, %", "clearance, m")


def print_benchmark(rows: Sequence[Row], seeds: str) -> None:
    """Print a row for each scenario, weather and driver, and how to read them."""
    ordered = sorted(rows, key=_benchmark_place)
    print_table(BENCHMARK, [_benchmark_cells(row) for row in ordered], words=3)
    print(f"\nSeeds {seeds}: {_answer(ordered[0].driver, rows)}.")
    print("After the slash: the paper, which does not define accuracy; ours is 1 - mean |u - u_PID| / 2.")


def _answer(driver: str, rows: Sequence[Row]) -> str:
    """How often a driver succeeded in all cells, and its least clearance."""
    own = [row for row in rows if row.driver == driver]
    gaps = [gap for row in own if (gap := row[LEAST_CLEARANCE]) is not None]
    successes, episodes = sum(row.successes for row in own), sum(row.episodes for row in own)
    passed = f", at least {min(gaps):.2f} m from parked cars" if gaps else ""
    return f"{driver} reached the goal in {successes} of {episodes} drives{passed}"


def _benchmark_place(row: Row) -> tuple[int, int, int, str]:
    """Sort key: scenarios, weathers and drivers in the benchmark's order, then a user's drivers."""
    from vpf_sim.evaluation.analysis.benchmark import DRIVERS, SCENARIOS, WEATHERS

    driver = DRIVERS.index(row.driver) if row.driver in DRIVERS else len(DRIVERS)
    return SCENARIOS.index(row.scenario), WEATHERS.index(row.weather), driver, row.driver


def _benchmark_cells(row: Row) -> tuple[str, ...]:
    """Means over the successful episodes, each beside the paper's value; a dash without success."""
    paper = row.paper or {}
    accuracies = [f"{percent(row[metric])} / {percent(paper.get(metric.paper))}" for metric in (THROTTLE, STEERING)]
    return (
        row.scenario,
        row.weather,
        driver_name(row),
        f"{row.successes}/{row.episodes}",
        f"{number(row[PATH_MSE], PATH_MSE.digits)} / {number(paper.get(PATH_MSE.paper))}",
        *accuracies,
        number(row[LEAST_CLEARANCE]),
    )
