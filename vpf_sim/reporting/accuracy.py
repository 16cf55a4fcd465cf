"""Tables of accuracy against the PID: by definition, protocol, and part of the route.

The paper does not define its accuracy, so its value is shown beside each of ours. The PID is the reference and has no
row.
"""

from collections.abc import Sequence

from vpf_sim.evaluation.analysis.comparisons import BASE_DRIVER
from vpf_sim.evaluation.analysis.rows import Row
from vpf_sim.evaluation.metrics.registry import BY_PART, PASSING, columns
from vpf_sim.reporting.cells import Order
from vpf_sim.reporting.kit.table import Line, Table, Value, formatted
from vpf_sim.reporting.tables import names, score

SIGNALS = ("throttle", "steering")
WHERE = ("scenario", "weather", "driver")


def by_definition(rows: Sequence[Row], order: Order, signal: str) -> Table | None:
    """A signal's accuracy in percent, one row per cell."""
    metrics = columns(signal)
    others = [row for row in order.sorted(rows) if row.driver != BASE_DRIVER]
    shown = [row for row in others if any(row[metric] is not None for metric in metrics)]
    lines: tuple[Line, ...] = tuple(
        (*names(row), *_paper(row, signal), *(score(row, metric) for metric in metrics)) for row in shown
    )
    paper = ["the paper, undefined"] if any(_paper(row, signal) for row in shown) else []
    return Table((*WHERE, *paper, *(metric.title for metric in metrics)), lines, 3) if lines else None


def by_part(rows: Sequence[Row], order: Order) -> Table | None:
    """Path MSE and accuracies clear of obstacles and passing one, one row per cell with obstacles."""
    shown = [row for row in order.sorted(rows) if row[PASSING] is not None]
    lines: tuple[Line, ...] = tuple((*names(row), *(score(row, metric) for metric in BY_PART)) for row in shown)
    return Table((*WHERE, *(metric.title for metric in BY_PART)), lines, 3) if lines else None


def _paper(row: Row, signal: str) -> tuple[Value, ...]:
    """The paper's value; empty in other runs."""
    if not row.paper:
        return ()
    value = row.paper[signal]
    return (Value(formatted(value, 2, True), value=value),)
