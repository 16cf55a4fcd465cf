"""The HTML page of a replay: the drives, the user's own first, then tables; it opens offline."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from vpf_sim.files import write_text
from vpf_sim.replay import frame_table
from vpf_sim.replay.frame_table import table_path, video_path
from vpf_sim.replay.plots import OURS, THEIRS, plots
from vpf_sim.replay.readers import general
from vpf_sim.replay.tables import tables
from vpf_sim.reporting.headline import listed
from vpf_sim.reporting.kit.clip import Clip
from vpf_sim.reporting.kit.page import formatted, render

NAME = "report.html"


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive's section of the page."""

    name: str
    answer: str
    clip: Clip | None
    plots: list[tuple[str, Markup]]


def write(folder: Path, records: list[dict[str, Any]], timing: dict[str, Any], summary: dict[str, Any]) -> Path:
    """Write the page of a replay folder and return its path."""
    ordered = sorted(records, key=lambda record: record["layout"] != general.LAYOUT)  # one's own before published ones
    text = render(
        "page.html.jinja",
        "vpf_sim.replay",
        title=title(ordered),
        tables=tables(ordered, timing, summary),
        drives=[_drive(folder, record) for record in ordered],
        ours=OURS,
        theirs=THEIRS,
    )
    write_text(folder / NAME, text)
    return folder / NAME


def _drive(folder: Path, record: dict[str, Any]) -> Drive:
    name, kinds = record["name"], {signal: origin["kind"] for signal, origin in record["origins"].items()}
    drawn = plots(frame_table.read(table_path(folder, name)), kinds)
    return Drive(name, drive_of(record), Clip.of_file(video_path(folder, name), folder), drawn)


def title(records: Sequence[dict[str, Any]]) -> str:
    """What the page shows: "What vpf commands on my_drive"."""
    if not records:
        return "No drive was replayed"
    return f"What {records[0]['driver']} commands on {listed([record['name'] for record in records])}"


def drive_of(record: dict[str, Any]) -> str:
    """Length of a drive, and the agreement of throttle and steering with the human's."""
    seconds = record["frames"] / record["rate_hz"] if record["rate_hz"] else 0.0
    length = f"{record['frames']} frames, {seconds:.0f} s"
    scores = record["accuracy"]
    if record["error"] is not None:
        return f"{length}: the driver failed at frame {record['error']['frame']}; not scored."
    if scores is None:
        return f"{length}: not scored, as there was no human driver."
    found = [_agreement(scores, signal) for signal in ("steering", "throttle") if scores[signal] is not None]
    return f"{length}: {'; '.join(found) or 'not scored, as the human commands are not known'}."


def _agreement(scores: dict[str, Any], signal: str) -> str:
    own, idle = (formatted(one[signal]["range"], 1, percent=True) for one in (scores, scores["idle"]))
    return f"{signal} agrees with the human's to {own} % (a driver that does nothing: {idle} %)"
