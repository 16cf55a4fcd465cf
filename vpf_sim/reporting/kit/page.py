"""Pages from templates, one file each that loads nothing, and tables for pages, Markdown and the terminal."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from vpf_sim.reporting.kit.chart import legend_key

KIT = "vpf_sim.reporting.kit"
Content = dict[str, Any]  # what a template is filled with, by name


def render(template: str, package: str = "vpf_sim.reporting", **content: Any) -> str:
    """A page of a package's template; `style` is the style sheet, `key` draws a legend's line."""
    loader = ChoiceLoader([PackageLoader(KIT, ""), PackageLoader(package, "")])
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, loader=loader
    )
    environment.globals["key"] = legend_key
    style = Markup(environment.get_template("page.css.jinja").render())
    return environment.get_template(template).render(style=style, **content)


NONE = "–"


@dataclass(frozen=True, slots=True)
class Value:
    """A number of a table: its text, small text beside it, and the exact value."""

    text: str
    beside: str = ""
    value: float | None = None


Cell = Value | str
Line = tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells; the first `names` columns name a row, those up to `words` are text, the others are numbers."""

    header: tuple[str, ...]
    rows: tuple[Line, ...]
    names: int = 1
    words: int = 0
    title: str = ""
    notes: tuple[str, ...] = ()
    faint: int = 0  # the number of rows in small print at the end

    @property
    def left(self) -> int:
        """The number of columns that are aligned to the left."""
        return max(self.names, self.words)

    def markdown(self) -> Iterator[str]:
        """The lines of the table in Markdown; small text is below its number."""
        yield markdown_row(self.header)
        yield markdown_row(["---" if i < self.left else "---:" for i in range(len(self.header))])
        for row in self.rows:
            yield markdown_row([_markdown(cell).replace("|", "\\|") for cell in row])


def markdown_row(cells: Sequence[str]) -> str:
    """One line of a Markdown table."""
    return f"| {' | '.join(cells)} |"


def _markdown(cell: Cell) -> str:
    if isinstance(cell, str):
        return cell
    return f"{cell.text}<br>{cell.beside}" if cell.beside else cell.text


def formatted(value: float | None, digits: int, percent: bool = False) -> str:
    """A formatted number, with a true minus sign; a dash for None."""
    if value is None:
        return NONE
    text = f"{100.0 * value if percent else value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text.replace("-", "−")


def interval_text(ends: tuple[float, float] | None, digits: int, percent: bool = False) -> str:
    """An interval as text, "0.40 to 0.47"; empty for None."""
    return "" if ends is None else " to ".join(formatted(end, digits, percent) for end in ends)
