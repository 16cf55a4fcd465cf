"""What commands print: tables, the keys of TOML files, and the streams that they print to."""

import io
import os
import sys
from collections.abc import Sequence
from dataclasses import MISSING
from typing import TYPE_CHECKING, Any, TextIO

from vpf_sim.cli.options import print_json
from vpf_sim.configuration_fields import Setting, sections, walk

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


def print_keys(config: type, json: bool) -> None:
    """Print each key with its default, its meaning and its bounds."""
    rows = [
        {"key": path, "default": _default(one), "meaning": one.meaning, "bounds": one.bounds}
        for path, one in walk(config)
        if not sections(one.hint)
    ]
    if json:
        print_json({"keys": rows})
        return
    for row in rows:
        row["meaning"] += f" ({row.pop('bounds')})" if row["bounds"] else ""
    print_table(("key", "default", "meaning"), [[row[key] for key in ("key", "default", "meaning")] for row in rows], 3)


def _default(setting: Setting) -> str:
    return "" if setting.default is MISSING else toml_value(setting.default)


def toml_value(value: Any) -> str:
    """A value as a TOML file has it; none stands for no value."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, bool | None):
        return "none" if value is None else str(value).lower()
    return repr(value) if isinstance(value, float | int) else str(value)


class _PipeTolerantFile(io.FileIO):
    """A file that ignores a closed reader, as in `vpf-sim ... | head`."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except BrokenPipeError:
            return len(data)


def reserve_stdout() -> None:
    """Reserve standard output for the result; all other writes to descriptor 1, also by native code, go to stderr.

    Characters that the encoding lacks are written as escapes.
    """
    for name in ("stdout", "stderr"):
        # One that the parent process closed: the next file that is opened would take its place.
        if getattr(sys, name) is None:
            setattr(sys, name, _text_stream(os.open(os.devnull, os.O_WRONLY), None))
    try:
        result = os.dup(1)
        os.dup2(2, 1)
    except OSError:
        return
    sys.stdout = _text_stream(result, sys.stdout)
    sys.stderr = _text_stream(os.dup(2), sys.stderr)


def _text_stream(descriptor: int, like: TextIO | None) -> TextIO:
    """A text stream on a descriptor, line-buffered on a terminal and for stderr."""
    os.set_inheritable(descriptor, False)
    file = _PipeTolerantFile(descriptor, "w")
    by_line = like is sys.stderr or file.isatty()
    encoding = getattr(like, "encoding", None) or "utf-8"
    return io.TextIOWrapper(
        io.BufferedWriter(file), encoding, errors="backslashreplace", line_buffering=by_line, write_through=by_line
    )
