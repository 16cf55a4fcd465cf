"""Text tables of sweeps."""

import json
from pathlib import Path
from typing import Any

from vpf_sim.api.progress import FAULTS
from vpf_sim.cli.tables import number, percent_within, print_table, within
from vpf_sim.reporting.cells import shown

Row = dict[str, Any]


def read_summary(path: Path) -> dict[str, Any]:
    """The summary of a finished run."""
    summary: dict[str, Any] = json.loads((path / "summary.json").read_bytes())
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
        "driving score",
    )
    print_table(header, [(shown(row["scenario"]), shown(row["weather"]), *_cells(row)) for row in rows], words=3)
    print(
        "\nMSE, throttle and steering (likeness to the PID in the same states): of drives that arrived. Driving score:"
    )
    print("CARLA Leaderboard 2.1's, the route driven less collisions and leaving the road, 0 to 1. 95 % intervals.")


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
    names = {key: shown(row[key]) for key in ("scenario", "weather")} | {"driver": row["driver"]}
    names[row["of"]] += f" - {shown(row['minus'])}"
    return names["scenario"], names["weather"], names["driver"]


def _difference(found: Row | None, digits: int) -> tuple[str, str, str]:
    if found is None:
        return "-", "-", "0"
    return within(found["difference"], found["interval"], digits), number(found["p"], 3), str(found["pairs"])


def driver_name(row: Row) -> str:
    """The driver with its privilege, if any."""
    privileged: str = row["privileged"]
    return str(row["driver"]) if privileged == "none" else f"{row['driver']} [{privileged}]"


def _cells(row: Row) -> tuple[str, ...]:
    accuracy = [
        percent_within(value_at(row, *path), _interval(row, *path))
        for path in (("accuracy", "shadow", signal, "range") for signal in ("throttle", "steering"))
    ]
    return (
        driver_name(row),
        f"{row['successes']}/{row['episodes']}",
        within(row["path_mse_m2"], _interval(row, "path_mse_m2"), 3),
        number(row["least_clearance_m"]),
        *accuracy,
        within(row["driving_score_2_1"], _interval(row, "driving_score_2_1")),
    )


def _interval(scores: Row, *path: str) -> Any:
    """The 95 % interval of a score; None for unsuccessful episodes."""
    return value_at(scores, "intervals", *path)


def value_at(table: Any, *path: str) -> Any:
    """The value under nested keys; None if one is missing."""
    for key in path:
        table = (table or {}).get(key)
    return table
