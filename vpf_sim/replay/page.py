"""The HTML page of a replay: the drives with their plots, the user's own first, then tables; it opens offline."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vpf_sim.files import write_text
from vpf_sim.replay import frame_table
from vpf_sim.replay.frame_table import FrameTable, table_path, video_path
from vpf_sim.replay.obstacles_ahead import closing_mps, true_ttc_s
from vpf_sim.replay.readers import general
from vpf_sim.replay.records import Accuracies, DriveRecord, Signal, Summary, Timing
from vpf_sim.replay.scores import SIGNALS
from vpf_sim.replay.tables import tables
from vpf_sim.reporting.headline import listed
from vpf_sim.reporting.kit.chart import Axis, Figure, Plot, reach
from vpf_sim.reporting.kit.clip import Clip
from vpf_sim.reporting.kit.page import formatted, render
from vpf_sim.types import Floats

NAME = "report.html"
WIDTH, HEIGHT = 360.0, 140.0
OURS, THEIRS = "command d0", "shadow"  # styles of lines
LEAST_COMMAND, LEAST_FOE_PX, MOST_TTC_S, LEAST_MPS = 0.1, 10.0, 20.0, 4.0  # ranges of axes


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive's section of the page."""

    name: str
    summary: str
    clip: Clip | None
    plots: tuple[Figure, ...]


def write(folder: Path, records: Sequence[DriveRecord], timing: Mapping[str, Timing], summary: Summary) -> Path:
    """Write the page of a replay folder and return its path."""
    ordered = sorted(records, key=lambda record: record.layout != general.LAYOUT)  # one's own before published ones
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


def title(records: Sequence[DriveRecord]) -> str:
    """What the page shows: "What vpf commands on my_drive"."""
    if not records:
        return "No drive was replayed"
    return f"What {records[0].driver} commands on {listed([record.name for record in records])}"


def _drive(folder: Path, record: DriveRecord) -> Drive:
    drawn = plots(frame_table.read(table_path(folder, record.name)), record)
    return Drive(record.name, summary_of(record), Clip.of_file(video_path(folder, record.name), folder), tuple(drawn))


def summary_of(record: DriveRecord) -> str:
    """Length of a drive, and the agreement of throttle and steering with the human's."""
    length = f"{record.frames} frames, {record.seconds:.0f} s"
    if record.error is not None:
        return f"{length}: the driver failed at frame {record.error.frame}; not scored."
    if record.accuracy is None:
        return f"{length}: not scored, as there was no human driver."
    found = [*_agreement(record.accuracy)]
    return f"{length}: {'; '.join(found) or 'not scored, as the human commands are not known'}."


def _agreement(scores: Accuracies) -> Iterator[str]:
    for signal in reversed(SIGNALS):
        own, idle = scores[signal], scores.idle[signal]
        if own is not None and idle is not None:
            shares = [formatted(one.range, 1, percent=True) for one in (own, idle)]
            yield f"{signal} agrees with the human's to {shares[0]} % (a driver that does nothing: {shares[1]} %)"


def plots(table: FrameTable, record: DriveRecord) -> Iterator[Figure]:
    """The plots with data: commands, focus of expansion, time to contact, speed."""
    kinds = {name: origin.kind for name, origin in record.origins.items()}
    yield from _command(table, "throttle", kinds["throttle"])
    yield from _command(table, "steering", kinds["steering_rad"])
    yield from _foe(table, "x")
    yield from _foe(table, "y")
    yield from _ttc(table)
    caption = "speed: by the road's flow, and recorded"
    yield from _chart(table, (table.flow_speed_mps, table.speed_mps), "speed, m/s", LEAST_MPS, caption)


def _command(table: FrameTable, name: Signal, kind: str) -> Iterator[Figure]:
    origin = "" if kind == "recorded" else f" ({kind})"
    both = getattr(table, name), getattr(table, f"recorded_{name}")
    return _chart(table, both, name, LEAST_COMMAND, f"{name}: predicted, and the human's{origin}")


def _foe(table: FrameTable, axis: str) -> Iterator[Figure]:
    """The error where the truth is known, else the position."""
    found, own, true = (getattr(table, f"{which}foe_{axis}_px") for which in ("", "own_", "true_"))
    rotation = "with and without recorded rotation"
    if np.isfinite(found - true).any() or np.isfinite(own - true).any():
        caption = f"focus of expansion, error in {axis}: {rotation}"
        return _chart(table, (found - true, own - true), f"error {axis}, px", LEAST_FOE_PX, caption)
    return _chart(table, (found, own), f"{axis}, px", LEAST_FOE_PX, f"focus of expansion, {axis}: {rotation}")


def _ttc(table: FrameTable) -> Iterator[Figure]:
    """Time to contact, capped at MOST_TTC_S."""
    if np.isfinite(table.lead_gap_m).any():
        true = true_ttc_s(table.lead_gap_m, closing_mps(table.lead_gap_m, table.time_s))
        both = np.minimum(table.ttc_s, MOST_TTC_S), np.minimum(true, MOST_TTC_S)
        what = "time to contact with the lead vehicle: by looming, and by the recorded gap"
        yield from _chart(table, both, "TTC, s", MOST_TTC_S, f"{what}; capped at {MOST_TTC_S:g} s")


def _chart(table: FrameTable, both: tuple[Floats, Floats], label: str, least: float, caption: str) -> Iterator[Figure]:
    """The driver's signal (N,) over the recorded one; nothing without values."""
    there = np.concatenate([values[np.isfinite(values)] for values in both])
    if not len(there):
        return
    low, high = reach([float(there.min()), float(there.max())], least)
    time = table.time_s - table.time_s[0]
    plot = Plot(WIDTH, HEIGHT, Axis(0.0, max(float(time[-1]), 0.1), "time, s"), Axis(low, high, label))
    plot.grid()
    for values, style in zip(reversed(both), (THEIRS, OURS), strict=True):
        plot.signal(time, values, style)
    yield Figure(caption, plot.svg(caption))
