"""The headline question of a report, and its answer in a few sentences."""

from collections.abc import Sequence
from typing import Any

from vpf_sim.drivers import describe
from vpf_sim.reporting.cells import Order, Row, formatted, shown

WHAT = {"town04-clean": "without obstacles", "town04": "with obstacles"}


def question(command: str, order: Order) -> str:
    """The question of a run."""
    if command == "benchmark":
        return "Does the visual potential field drive the paper's road, and as well as the paper reports?"
    if len(order.drivers) == 1:
        return f"Does {order.drivers[0]} reach its goals, and how well does it drive?"
    return "Which drivers reach their goals, and how well does each drive?"


def sentences(command: str, rows: Sequence[Row], order: Order) -> list[str]:
    """The verdict, the success of each driver, and the first driver's path MSE beside the paper's."""
    first, *others = (_success(driver, rows) for driver in order.drivers)
    asked = command == "benchmark" or not others
    return [_verdict(order.drivers[0], rows) + first if asked else first, *others, *_against_paper(rows, order)]


def _verdict(driver: str, rows: Sequence[Row]) -> str:
    """Whether a driver reached all, some or none of its goals."""
    reached, planned = _counts(driver, rows)
    return "Yes: " if reached == planned else "Not always: " if reached else "No: "


def _counts(driver: str, rows: Sequence[Row]) -> tuple[int, int]:
    """Numbers of episodes that reached the goal, and that were planned."""
    own = [row for row in rows if row["driver"] == driver]
    return sum(row["successes"] for row in own), sum(row["episodes"] for row in own)


def _success(driver: str, rows: Sequence[Row]) -> str:
    own = [row for row in rows if row["driver"] == driver]
    reached, planned = _counts(driver, rows)
    summary = f", {text}" if (text := _summary(driver)) else ""
    return f"{driver}{summary}: {reached} of {planned} episodes reached the goal{_where(own)}."


def _summary(driver: str) -> str:
    """The summary of a registered driver; empty for a user's driver."""
    return next((known.summary for known in describe() if known.name == driver), "")


def _where(own: Sequence[Row]) -> str:
    """The cells with failures, if they are few."""
    bad = [row for row in own if row["successes"] < row["episodes"]]
    if not bad or len(bad) == len(own) or len(bad) > 4:
        return ""
    failing = (
        f"{row['successes']} of {row['episodes']} on {shown(row['scenario'])} in {shown(row['weather'])}" for row in bad
    )
    return f"; {', '.join(failing)}, all in the others"


def _against_paper(rows: Sequence[Row], order: Order) -> list[str]:
    """A sentence with the first driver's path MSE beside the paper's; empty without both."""
    first = order.drivers[0]
    own = [row for row in sorted(rows, key=order.place) if row["driver"] == first and row.get("paper")]
    scored = [row for row in own if row["path_mse_m2"] is not None]
    if not scored:
        return []
    pairs = ", ".join(f"{formatted(row['path_mse_m2'], 3)} ({_cell(row)}; paper {_paper(row)})" for row in scored)
    return [f"Path MSE of {first}, m²: {pairs}. Simulator and camera differ: see below."]


def _cell(row: Row) -> str:
    return f"{row['weather']}, {WHAT.get(row['scenario'], row['scenario'])}"


def _paper(row: Row) -> str:
    paper: dict[str, Any] = row["paper"]
    return formatted(paper["path_mse_m2"], 2)
