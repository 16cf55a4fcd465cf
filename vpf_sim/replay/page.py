"""The HTML page of a replay: tables, plots and videos; it opens offline."""

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
from vpf_sim.replay.run_files import table_path, video_path
from vpf_sim.replay.tables import tables
from vpf_sim.reporting.chart import legend_key

NAME = "report.html"
MOST_INSIDE_BYTES = 4_000_000  # of an embedded video; larger ones are linked


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive's section of the page."""

    name: str
    video: str  # a data URI, a path beside the page, or empty
    beside: bool
    plots: list[tuple[str, Markup]]


def write(folder: Path, records: list[dict[str, Any]], timing: dict[str, Any], summary: dict[str, Any]) -> Path:
    """Write the page of a replay folder and return its path."""
    drives = [_drive(folder, record) for record in records]
    driver = records[0]["driver"] if records else ""
    text = _render(driver=driver, tables=tables(records, timing, summary), drives=drives, ours=OURS, theirs=THEIRS)
    write_text(folder / NAME, text)
    return folder / NAME


def _drive(folder: Path, record: dict[str, Any]) -> Drive:
    name, kinds = record["name"], {signal: origin["kind"] for signal, origin in record["origins"].items()}
    video = video_path(folder, name)
    drawn = plots(frame_table.read(table_path(folder, name)), kinds)
    if not video.exists():
        return Drive(name, "", False, drawn)
    if video.stat().st_size > MOST_INSIDE_BYTES:
        return Drive(name, video.relative_to(folder).as_posix(), True, drawn)
    inside = b64encode(video.read_bytes()).decode("ascii")
    return Drive(name, f"data:video/mp4;base64,{inside}", False, drawn)


def _render(**content: Any) -> str:
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.globals["key"] = legend_key
    style = files("vpf_sim.reporting").joinpath("report.css.jinja").read_text("utf-8")
    template = files("vpf_sim.replay").joinpath("page.html.jinja").read_text("utf-8")
    return environment.from_string(template).render(style=Markup(environment.from_string(style).render()), **content)
