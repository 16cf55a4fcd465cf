"""Tables of accuracy against the PID: by definition, protocol, and part of the route.

The paper does not define its accuracy, so its value is shown beside each of ours. The PID is the reference and has no
row.
"""

from collections.abc import Sequence

from vpf_sim.evaluation.analysis.comparisons import BASE_DRIVER
from vpf_sim.reporting.cells import Order, Row, at, formatted
from vpf_sim.reporting.tables import Table, Value, names, score, scored

PROTOCOLS = ("shadow", "paired")
DEFINITIONS = ("range", "span", "tolerance")
SIGNALS = ("throttle", "steering")
PARTS = ("clear_of_obstacles", "passing")
BY_PART = {  # key, label, digits, in percent
    "path_mse_parts_m2.{part}": ("path MSE, m²", 3, False),
    "accuracy.shadow.{part}.throttle.range": ("throttle, %", 1, True),
    "accuracy.shadow.{part}.steering.range": ("steering, %", 1, True),
}


def by_definition(rows: Sequence[Row], order: Order, signal: str) -> Table | None:
    """A signal's accuracy in percent, one row per cell."""
    others = [row for row in sorted(rows, key=order.place) if row["driver"] != BASE_DRIVER]
    shown = [row for row in others if at(scored(row), f"accuracy.shadow.{signal}")]
    keys = [f"accuracy.{protocol}.{signal}.{name}" for protocol in PROTOCOLS for name in DEFINITIONS]
    lines = tuple((*names(row), *_paper(row, signal), *(score(row, key, 1, True) for key in keys)) for row in shown)
    labels = [f"{protocol}, {name}" for protocol in PROTOCOLS for name in DEFINITIONS]
    paper = ["the paper, undefined"] if any(_paper(row, signal) for row in shown) else []
    return Table(("scenario", "weather", "driver", *paper, *labels), lines, 3) if lines else None


def by_part(rows: Sequence[Row], order: Order) -> Table | None:
    """Path MSE and accuracies clear of obstacles and passing one, one row per cell with obstacles."""
    shown = [row for row in sorted(rows, key=order.place) if at(scored(row), "path_mse_parts_m2.passing") is not None]
    columns = [
        (key.format(part=part), f"{label}, {part.replace('_', ' ')}", digits, percent)
        for key, (label, digits, percent) in BY_PART.items()
        for part in PARTS
    ]
    lines = tuple(
        (*names(row), *(score(row, key, digits, percent) for key, _, digits, percent in columns)) for row in shown
    )
    header = ("scenario", "weather", "driver", *(label for _, label, *_ in columns))
    return Table(header, lines, 3) if lines else None


def _paper(row: Row, signal: str) -> tuple[Value, ...]:
    """The paper's value; empty in other runs."""
    if not row.get("paper"):
        return ()
    value = row["paper"][signal]
    return (Value(formatted(value, 2, True), value=value),)
