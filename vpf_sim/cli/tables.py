"""Plain-text tables."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vpf_sim.evaluation.metrics.metric import Metric
    from vpf_sim.evaluation.metrics.records import Record


def print_table(header: Sequence[str], rows: Sequence[Sequence[str]], words: int = 1, prose: bool = False) -> None:
    """Print aligned columns: the first `words` and, with `prose`, the last to the left, the others to the right."""
    lines = [list(header), *([in_one_line(cell) for cell in row] for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]
    rule = ["-" * width for width in widths]
    for line in [lines[0], rule, *lines[1:]]:
        cells = [
            cell.ljust(width) if i < words or (prose and i == len(header) - 1) else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        ]
        print("  ".join(cells).rstrip())


def in_one_line(text: str) -> str:
    """A user's text in one line, with control characters escaped."""
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def number(value: float | None, digits: int = 2) -> str:
    """A number with `digits` decimals, or a dash for None."""
    return "-" if value is None else f"{value:.{digits}f}"


def measure(value: float | None, unit: str, digits: int = 2) -> str:
    """A number with its unit, or a dash for None."""
    return number(value, digits) if value is None else f"{number(value, digits)} {unit}"


def measured(metric: "Metric", record: "Record") -> str:
    """The value of a metric with its unit, or a dash where there is none."""
    value = record[metric]
    scaled = 100.0 * value if value is not None and metric.percent else value
    return measure(scaled, plain_unit(metric), metric.digits)


def plain_unit(metric: "Metric") -> str:
    """The unit in plain letters: "m2"."""
    return metric.unit.replace("²", "2")


def shown(metric: "Metric", value: float | None, interval: Sequence[float] | None = None) -> str:
    """A value of a metric with its interval, without the unit."""
    if metric.percent:
        return percent_within(value, interval)
    return within(value, interval, metric.digits)


def percent(share: float | None) -> str:
    """A share as a percentage with one decimal."""
    return "-" if share is None else f"{100.0 * share:.1f}"


def within(value: float | None, interval: Sequence[float] | None, digits: int = 2) -> str:
    """A number with its interval if there is one, such as "0.43 [0.40, 0.47]"."""
    if value is None or interval is None:
        return number(value, digits)
    return f"{number(value, digits)} [{', '.join(number(end, digits) for end in interval)}]"


def percent_within(share: float | None, interval: Sequence[float] | None) -> str:
    """A share and its interval as percentages with one decimal."""
    scaled = None if interval is None else [100.0 * end for end in interval]
    return within(None if share is None else 100.0 * share, scaled, 1)
