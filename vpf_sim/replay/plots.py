"""The plots of a replayed drive: commands, focus of expansion, time to contact, speed."""

from collections.abc import Mapping

import numpy as np
from markupsafe import Markup

from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.replay.obstacles_ahead import closing_mps, true_ttc_s
from vpf_sim.reporting.kit.chart import Axis, Plot, reach
from vpf_sim.types import Floats

WIDTH, HEIGHT = 360.0, 140.0
OURS, THEIRS, THIRD = "command d0", "shadow", "own"
LEAST_COMMAND, LEAST_FOE_PX, MOST_TTC_S = 0.1, 10.0, 20.0


def plots(table: FrameTable, kinds: Mapping[str, str]) -> list[tuple[str, Markup]]:
    """Caption and drawing of each plot with data; `kinds` are those of the recording's signals."""
    drawn = [
        _command(table, "throttle", kinds["throttle"]),
        _command(table, "steering", kinds["steering_rad"]),
        _foe(table, "x"),
        _foe(table, "y"),
        _ttc(table),
        _speed(table),
    ]
    return [plot for plot in drawn if plot is not None]


def _command(table: FrameTable, name: str, kind: str) -> tuple[str, Markup] | None:
    series = [(getattr(table, name), OURS), (getattr(table, f"recorded_{name}"), THEIRS)]
    origin = "" if kind == "recorded" else f" ({kind})"
    return _chart(table, series, name, LEAST_COMMAND, f"{name}: predicted, and the human's{origin}")


def _foe(table: FrameTable, axis: str) -> tuple[str, Markup] | None:
    """The error where the truth is known, else the position."""
    found, own, true = (getattr(table, f"{which}foe_{axis}_px") for which in ("", "own_", "true_"))
    if np.isfinite(found - true).any() or np.isfinite(own - true).any():
        caption = f"focus of expansion, error in {axis}: with and without recorded rotation"
        return _chart(table, [(found - true, OURS), (own - true, THEIRS)], f"error {axis}, px", LEAST_FOE_PX, caption)
    caption = f"focus of expansion, {axis}: with and without recorded rotation"
    return _chart(table, [(found, OURS), (own, THEIRS)], f"{axis}, px", LEAST_FOE_PX, caption)


def _ttc(table: FrameTable) -> tuple[str, Markup] | None:
    """Time to contact, capped at MOST_TTC_S."""
    if not np.isfinite(table.lead_gap_m).any():
        return None
    true = true_ttc_s(table.lead_gap_m, closing_mps(table.lead_gap_m, table.time_s))
    series = [(np.minimum(table.ttc_s, MOST_TTC_S), OURS), (np.minimum(true, MOST_TTC_S), THEIRS)]
    caption = f"time to contact with the lead vehicle: by looming, and by the recorded gap; capped at {MOST_TTC_S:g} s"
    return _chart(table, series, "TTC, s", MOST_TTC_S, caption)


def _speed(table: FrameTable) -> tuple[str, Markup] | None:
    series = [(table.flow_speed_mps, OURS), (table.speed_mps, THEIRS)]
    return _chart(table, series, "speed, m/s", 4.0, "speed: by the road's flow, and recorded")


def _chart(
    table: FrameTable, series: list[tuple[Floats, str]], label: str, least: float, caption: str
) -> tuple[str, Markup] | None:
    there = np.concatenate([values[np.isfinite(values)] for values, _ in series])
    if not len(there):
        return None
    low, high = reach([float(there.min()), float(there.max())], least)
    time = table.time_s - table.time_s[0]
    plot = Plot(WIDTH, HEIGHT, Axis(0.0, max(float(time[-1]), 0.1), "time, s"), Axis(low, high, label))
    plot.grid()
    for values, style in reversed(series):
        plot.signal(time, values, style)
    return caption, plot.svg(caption)
