"""The page of a replay: tables, plots and films in one HTML file that opens offline."""

from base64 import b64encode
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from vpf_sim.files import write_text
from vpf_sim.replay import frame_table
from vpf_sim.replay.plots import OURS, THEIRS, plots
from vpf_sim.replay.run_files import film_file, table_file
from vpf_sim.replay.tables import tables
from vpf_sim.report.chart import legend_key

NAME = "report.html"
MOST_INSIDE_BYTES = 4_000_000  # of a film that lies inside the page; larger ones stay beside it


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive's part of the page."""

    name: str
    video: str  # a data URI, a path beside the page, or empty
    beside: bool
    plots: list[tuple[str, Markup]]


def write(folder: Path, records: list[dict[str, Any]], timing: dict[str, Any], summary: dict[str, Any]) -> Path:
    """The page of what is in a replay's folder."""
    drives = [_drive(folder, record) for record in records]
    driver = records[0]["driver"] if records else ""
    text = _render(driver=driver, tables=tables(records, timing, summary), drives=drives, ours=OURS, theirs=THEIRS)
    write_text(folder / NAME, text)
    return folder / NAME


def _drive(folder: Path, record: dict[str, Any]) -> Drive:
    name, kinds = record["name"], {signal: origin["kind"] for signal, origin in record["origins"].items()}
    film = film_file(folder, name)
    drawn = plots(frame_table.read(table_file(folder, name)), kinds)
    if not film.exists():
        return Drive(name, "", False, drawn)
    if film.stat().st_size > MOST_INSIDE_BYTES:
        return Drive(name, film.relative_to(folder).as_posix(), True, drawn)
    inside = b64encode(film.read_bytes()).decode("ascii")
    return Drive(name, f"data:video/mp4;base64,{inside}", False, drawn)


def _render(**content: Any) -> str:
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.globals["key"] = legend_key
    style = files("vpf_sim.report").joinpath("report.css.jinja").read_text("utf-8")
    template = files("vpf_sim.replay").joinpath("page.html.jinja").read_text("utf-8")
    return environment.from_string(template).render(style=Markup(environment.from_string(style).render()), **content)
