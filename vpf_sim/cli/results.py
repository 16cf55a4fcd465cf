"""Text tables of sweeps and benchmarks."""

import json
from itertools import groupby
from pathlib import Path
from typing import Any

from vpf_sim.api.progress import FAULTS
from vpf_sim.cli.tables import number, percent, percent_within, print_table, within

Row = dict[str, Any]
DEFINITIONS = ("range", "span", "tolerance")


def read_summary(path: Path) -> dict[str, Any]:
    """The summary of a finished run."""
    summary: dict[str, Any] = json.loads((path / "summary.json").read_text("utf-8"))
    return summary


def exit_code(summary: dict[str, Any]) -> int:
    """1 if any episode ended by a fault of the harness or the driver's code; a collision is a result."""
    return int(any(fault in row["statuses"] for row in summary["rows"] for fault in FAULTS))


def print_rows(rows: list[Row]) -> None:
    """Print a sweep's table."""
    header = (
        "scenario",
        "weather",
        "driver",
        "success",
        "MSE m2",
        "clearance m",
        "throttle %",
        "steering %",
        "score 2.1",
    )
    print_table(header, [(row["scenario"], row["weather"], *_cells(row)) for row in rows], words=3)
    print("\nMSE, clearance and accuracy (range, shadow): successful episodes; in (brackets): the others if none did;")
    print("with 95 % intervals.")


def print_comparisons(comparisons: list[Row]) -> None:
    """Print paired differences between weathers and drivers, if there are any."""
    if not comparisons:
        return
    print("\nDifferences on the same seeds, with 95 % intervals and p of no difference:\n")
    header = ("scenario", "weather", "driver", "success", "p", "seeds", "MSE m2", "p", "seeds")
    lines = [
        (*_sides(row), *_difference(row["success_rate"], 2), *_difference(row["path_mse_m2"], 3)) for row in comparisons
    ]
    print_table(header, lines, words=3)
    print("\nSuccess over the planned seeds (McNemar's test), MSE where both succeeded (sign flips). Of many p values,")
    print("some are small by chance.")


def _sides(row: Row) -> tuple[str, str, str]:
    """The compared cells, such as "rain - clear" or "vpf - pid"."""
    names = {key: row[key] for key in ("scenario", "weather", "driver")}
    names[row["of"]] += f" - {row['minus']}"
    return names["scenario"], names["weather"], names["driver"]


def _difference(found: Row | None, digits: int) -> tuple[str, str, str]:
    if found is None:
        return "-", "-", "0"
    return within(found["difference"], found["interval"], digits), number(found["p"], 3), str(found["pairs"])


def print_benchmark(rows: list[Row], seeds: str) -> None:
    """Print the paper's table: each of its cells, then our drivers in that cell."""
    print(f"Seeds {seeds}. Accuracy against the PID, shadow protocol, in %: range / span / tolerance.\n")
    header = ("scenario", "weather", "driver", "success", "MSE m2", "throttle", "steering", "clearance m")
    lines: list[tuple[str, ...]] = []
    for cell, group in groupby(sorted(rows, key=_place), key=_cell):
        ours = list(group)
        paper = ours[0]["paper"]
        lines.append((*cell, "the paper", "", number(paper["path_mse_m2"]), *_paper_accuracy(paper), ""))
        lines += [(*cell, _driver(row), *_benchmark_cells(row)) for row in ours]
    print_table(header, lines, words=3)
    _print_protocols(rows)
    print("\nMeans over the successful episodes, with 95 % intervals; in (brackets) over all if none succeeded. The")
    print('paper does not define its accuracy; its rows are "Cloudy" and "Rain", its set-up Clear Noon and Hard')
    print("Rain; its camera and simulator are CARLA's.")


def _print_protocols(rows: list[Row]) -> None:
    """Print the accuracy `range` by protocol and part of the route."""
    print("\nAccuracy by range in %, throttle / steering:\n")
    header = (
        "scenario",
        "weather",
        "driver",
        "shadow",
        "clear of obstacles",
        "passing",
        "paired",
        "clear of obstacles",
        "passing",
    )
    lines = [
        (*_cell(row), _driver(row), *(part for protocol in ("shadow", "paired") for part in _parts(row, protocol)))
        for row in sorted(rows, key=_place)
    ]
    print_table(header, lines, words=3)


def _cell(row: Row) -> tuple[str, str]:
    """The cell of the paper's table."""
    return row["scenario"], row["weather"]


def _place(row: Row) -> tuple[int, int, int, str]:
    """Sort key: scenarios, weathers and drivers in the benchmark's order, then a user's drivers."""
    from vpf_sim.evaluation.analysis.benchmark import DRIVERS, SCENARIOS, WEATHERS

    driver = DRIVERS.index(row["driver"]) if row["driver"] in DRIVERS else len(DRIVERS)
    return SCENARIOS.index(row["scenario"]), WEATHERS.index(row["weather"]), driver, row["driver"]


def _driver(row: Row) -> str:
    """The driver with its privilege, if any."""
    privileged: str = row["privileged"]
    return str(row["driver"]) if privileged == "none" else f"{row['driver']} [{privileged}]"


def _parts(row: Row, protocol: str) -> list[str]:
    scores, bracket = _scores(row)
    whole = (scores["accuracy"] or {}).get(protocol) or {}
    parts = [whole, whole.get("clear_of_obstacles") or {}, whole.get("passing") or {}]
    return [
        bracket(" / ".join(percent((part.get(signal) or {}).get("range")) for signal in ("throttle", "steering")))
        for part in parts
    ]


def _paper_accuracy(paper: Row) -> tuple[str, str]:
    return f"{100.0 * paper['throttle']:.2f}", f"{100.0 * paper['steering']:.2f}"


def _benchmark_cells(row: Row) -> tuple[str, ...]:
    scores, bracket = _scores(row)
    throttle, steering = (bracket(_definitions(scores, signal)) for signal in ("throttle", "steering"))
    return (
        f"{row['successes']}/{row['episodes']}",
        bracket(within(scores["path_mse_m2"], _interval(scores, "path_mse_m2"), 3)),
        throttle,
        steering,
        number(row["least_clearance_m"]),
    )


def _cells(row: Row) -> tuple[str, ...]:
    scores, bracket = _scores(row)
    accuracy = [
        bracket(percent_within(_at(scores, *path), _interval(scores, *path)))
        for path in (("accuracy", "shadow", signal, "range") for signal in ("throttle", "steering"))
    ]
    return (
        _driver(row),
        f"{row['successes']}/{row['episodes']}",
        bracket(within(scores["path_mse_m2"], _interval(scores, "path_mse_m2"), 3)),
        number(row["least_clearance_m"]),
        *accuracy,
        within(row["driving_score_2_1"], _interval(row, "driving_score_2_1")),
    )


def _interval(scores: Row, *path: str) -> Any:
    """The 95 % interval of a score; None for unsuccessful episodes."""
    return _at(scores, "intervals", *path)


def _at(table: Any, *path: str) -> Any:
    """The value under nested keys; None if one is missing."""
    for key in path:
        table = (table or {}).get(key)
    return table


def _definitions(scores: Row, signal: str) -> str:
    shadow = (scores["accuracy"] or {}).get("shadow") or {}
    return " / ".join(percent((shadow.get(signal) or {}).get(name)) for name in DEFINITIONS)


def _scores(row: Row) -> tuple[Row, Any]:
    """The scores of the successful episodes, or else the others', and a function that adds brackets to the others'."""
    if row["successes"]:
        return row, str
    return row["unsuccessful"], lambda text: text if set(text) <= set("-/ ") else f"({text})"
