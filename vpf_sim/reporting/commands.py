"""Charts of throttle and steering over distance, with the PID's by both protocols."""

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting.kit.chart import Axis, Plot, reach
from vpf_sim.types import Floats

WIDTH, HEIGHT = 360.0, 130.0
MOST = 1.06  # the largest end of an axis, slightly beyond the command limit
LEAST = 0.3  # least range of an axis


@dataclass(frozen=True, slots=True)
class CommandCharts:
    """The command charts of one episode."""

    episode: str
    throttle: Markup
    steering: Markup


def charts(episode: str, style: str, table: StepTable) -> CommandCharts:
    """The driver's commands, the PID's in the same states, and those of its own run at the same distances."""
    throttle = _chart(table, (table.throttle, table.pid_throttle, table.paired_throttle), style, "throttle", episode)
    steering = _chart(table, (table.steering, table.pid_steering, table.paired_steering), style, "steering", episode)
    return CommandCharts(episode, throttle, steering)


def _chart(table: StepTable, series: tuple[Floats, Floats, Floats], style: str, name: str, episode: str) -> Markup:
    values = np.concatenate([[0.0], *series])
    values = values[np.isfinite(values)]
    low, high = reach([float(values.min()), float(values.max())], LEAST)
    low, high = max(low, -MOST), min(high, MOST)
    plot = Plot(WIDTH, HEIGHT, Axis(0.0, float(table.route_m[-1]), "distance, m"), Axis(low, high, name))
    plot.grid()
    for signal, stroke in zip(series[::-1], ("own", "shadow", f"command {style}"), strict=True):
        plot.signal(table.route_m, signal, stroke)
    return plot.svg(f"{episode}: {name} over distance")
