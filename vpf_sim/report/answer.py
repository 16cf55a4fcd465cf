"""The question that a run asks, and its answer in a few sentences, made from its summary."""

from collections.abc import Sequence
from typing import Any

from vpf_sim.drivers import describe
from vpf_sim.report.cells import Order, Row, shown, worded

WHAT = {"town04-clean": "without obstacles", "town04": "with obstacles"}


def question(command: str, order: Order) -> str:
    """What was asked."""
    if command == "benchmark":
        return "Does the visual potential field drive the paper's road, and as well as the paper says?"
    if len(order.drivers) == 1:
        return f"Does {order.drivers[0]} arrive, and how well does it drive?"
    return "Which driver arrives, and how well does each drive?"


def sentences(command: str, rows: Sequence[Row], order: Order) -> list[str]:
    """Yes or no where the question asks it, who arrived, and how the first driver compares with the paper."""
    first, *others = (_arrivals(driver, rows) for driver in order.drivers)
    asked = command == "benchmark" or not others
    return [_verdict(order.drivers[0], rows) + first if asked else first, *others, *_against_paper(rows, order)]


def _verdict(driver: str, rows: Sequence[Row]) -> str:
    """The shortest answer to whether a driver arrives."""
    arrived, planned = _counts(driver, rows)
    return "Yes: " if arrived == planned else "Not always: " if arrived else "No: "


def _counts(driver: str, rows: Sequence[Row]) -> tuple[int, int]:
    """Episodes that reached the goal, and that were planned."""
    own = [row for row in rows if row["driver"] == driver]
    return sum(row["successes"] for row in own), sum(row["episodes"] for row in own)


def _arrivals(driver: str, rows: Sequence[Row]) -> str:
    own = [row for row in rows if row["driver"] == driver]
    arrived, planned = _counts(driver, rows)
    told = f", {words}" if (words := _summary(driver)) else ""
    return f"{driver}{told}: {arrived} of {planned} episodes reached the goal{_where(own)}."


def _summary(driver: str) -> str:
    """What a registered driver is, in a line; of a user's own nothing is known."""
    return next((known.summary for known in describe() if known.name == driver), "")


def _where(own: Sequence[Row]) -> str:
    """Where the failures are, if only in some cells."""
    bad = [row for row in own if row["successes"] < row["episodes"]]
    if not bad or len(bad) == len(own) or len(bad) > 4:
        return ""
    told = (
        f"{row['successes']} of {row['episodes']} on {shown(row['scenario'])} in {shown(row['weather'])}" for row in bad
    )
    return f"; {', '.join(told)}, all elsewhere"


def _against_paper(rows: Sequence[Row], order: Order) -> list[str]:
    """The path MSE of the first driver beside the paper's, where both have one."""
    first = order.drivers[0]
    told = [row for row in sorted(rows, key=order.place) if row["driver"] == first and row.get("paper")]
    scored = [row for row in told if row["path_mse_m2"] is not None]
    if not scored:
        return []
    pairs = ", ".join(f"{worded(row['path_mse_m2'], 3)} ({_cell(row)}; paper {_paper(row)})" for row in scored)
    return [f"Path MSE of {first}, m²: {pairs}. Another simulator and another camera: see what differs."]


def _cell(row: Row) -> str:
    return f"{row['weather']}, {WHAT.get(row['scenario'], row['scenario'])}"


def _paper(row: Row) -> str:
    paper: dict[str, Any] = row["paper"]
    return worded(paper["path_mse_m2"], 2)
