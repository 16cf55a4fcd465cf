"""One episode as a page: scores, the path over the road, and signals over the distance."""

import numpy as np

from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import CLEARANCE, COMPLETION, PATH_MSE
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting import figures, paths
from vpf_sim.reporting.kit.chart import Axis, Figure, Plot, reach
from vpf_sim.reporting.kit.page import render
from vpf_sim.reporting.main_table import text_of
from vpf_sim.reporting.road_layout import layouts

STYLE = "d0"  # the first driver's
LEAST_MPS = 2.0  # least range of the speed's axis


def page(record: Record, table: StepTable, inputs: RunInputs) -> str:
    """The page in HTML; it loads nothing."""
    layout = layouts(inputs.scenario(record.scenario), [record.seed])
    track = paths.Track(record.seed, STYLE, record.succeeded, table)
    commands = figures.charts(record.id, STYLE, table)
    signals = [
        Figure("Throttle; negative brakes.", commands.throttle),
        Figure("Steering.", commands.steering),
        _speed(record, table),
    ]
    return render(
        "episode.html.jinja",
        title=record.id,
        sentences=sentences(record, table),
        paths=paths.charts(layout, [track], record.id),
        signals=signals,
    )


def sentences(record: Record, table: StepTable) -> list[str]:
    """How the episode ended, and its main scores; those of the path only where it arrived."""
    measured = [COMPLETION, CLEARANCE, *([PATH_MSE] if record.succeeded else [])]
    scores = [
        f"{metric.title} {text_of(metric, record[metric])} {metric.unit}"
        for metric in measured
        if record[metric] is not None
    ]
    return [f"{record.ending} after {table.time_s[-1]:.1f} s", *scores]


def _speed(record: Record, table: StepTable) -> Figure:
    low, high = reach([0.0, float(np.max(table.speed_mps))], LEAST_MPS)
    axes = Axis(0.0, float(table.route_m[-1]), "distance, m"), Axis(max(low, 0.0), high, "speed, m/s")
    plot = Plot(figures.WIDTH, figures.HEIGHT, *axes)
    plot.grid()
    plot.signal(table.route_m, table.speed_mps, f"command {STYLE}")
    return Figure("Speed.", plot.svg(f"{record.id}: speed over distance"))
