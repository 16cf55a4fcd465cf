"""The charts of a report: paths and commands by scenario and weather, and dot charts of scores."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from markupsafe import Markup

from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.rows import Row
from vpf_sim.evaluation.metrics.metric import Metric
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import columns
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting import paths
from vpf_sim.reporting.kit import interval_chart
from vpf_sim.reporting.kit.chart import Axis, Figure, Plot, reach
from vpf_sim.reporting.main_table import Order, shown
from vpf_sim.reporting.paths import Track
from vpf_sim.reporting.road_layout import layouts
from vpf_sim.reporting.run_data import RunData, StoredRun
from vpf_sim.types import Floats

MOST_TRACKS = 30  # seeds with drawn paths
MOST_PATHS, MOST_COMMANDS = 12, 6  # pairs of scenario and weather
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


@dataclass(frozen=True, slots=True)
class Section:
    """The charts of one scenario in one weather."""

    title: str
    drivers: tuple[str, ...]
    paths: tuple[Figure, ...]


@dataclass(slots=True)
class Sections:
    """The drawn sections, the charts of commands, and reasons for those left out."""

    drawn: list[Section] = field(default_factory=list)
    commands: list[CommandCharts] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)


def sections(run_data: RunData) -> Sections:
    """Charts of paths and commands for each scenario and weather."""
    found, changed = Sections(), run_data.changed()
    for number, (scenario, weather) in enumerate(run_data.order.cells()):
        title = f"{shown(scenario)}, {shown(weather)}"
        if number >= MOST_PATHS:
            found.left_out.append(f"{title}: only the first {MOST_PATHS} are drawn")
        elif scenario in changed:
            found.left_out.append(f"{title}: the scenario has changed since the run")
        else:
            _add(found, run_data, scenario, weather, title)
    return found


def _add(found: Sections, run_data: RunData, scenario: str, weather: str, title: str) -> None:
    here = run_data.at(scenario, weather)
    seeds = sorted({record.seed for record in here})[:MOST_TRACKS]
    tracks = list(_tracks(run_data, [record for record in here if record.seed in seeds]))
    if not tracks:
        found.left_out += _lost(run_data.run, here, title)
        return
    try:
        where = layouts(run_data.run.inputs.scenario(scenario), seeds)
    except InputError as error:
        found.left_out.append(f"{title}: {error}")
        return
    first = [record for record in here if record.seed == seeds[0] and record.driver != "pid"]
    if len(found.drawn) < MOST_COMMANDS:
        found.commands += _commands(run_data.run, run_data.order, first)
    drivers = tuple(dict.fromkeys(record.driver for record in here))
    found.drawn.append(Section(title, drivers, tuple(paths.charts(where, tracks, title))))


def _lost(run: StoredRun, records: Sequence[Record], title: str) -> Iterator[str]:
    """That the steps of driven episodes are gone, if they are."""
    lost = [record.id for record in records if record.steps]
    if lost:
        yield f"{title}: {len(lost)} driven episodes have no steps in {run.path / 'steps'} any more"


def _tracks(run_data: RunData, records: Sequence[Record]) -> Iterator[Track]:
    """The paths; the first driver's come last and are drawn on top."""
    for record in reversed(records):
        table = run_data.run.steps(record.id)
        if table is not None:
            yield Track(record.seed, run_data.order.style(record.driver), record.succeeded, table)


def _commands(run: StoredRun, order: Order, records: Sequence[Record]) -> Iterator[CommandCharts]:
    for record in records:
        table = run.steps(record.id)
        if table is not None:
            yield charts(record.id, order.style(record.driver), table)


def scores(rows: Sequence[Row], order: Order) -> Iterator[Figure]:
    """One chart per score, with the paper's values."""
    for metric in columns("chart"):
        found = [dot for row in rows if (dot := _dot(row, metric, order))]
        if found:
            scale, title = _scale(metric), f"{metric.heading[0].upper()}{metric.heading[1:]}"
            ends = None if metric.perfect is None else (0.0, scale * metric.perfect)
            yield Figure(title, interval_chart.chart(found, _marks(rows, order, metric), title, ends))


def _scale(metric: Metric) -> float:
    return 100.0 if metric.percent else 1.0


def _dot(row: Row, metric: Metric, order: Order) -> interval_chart.Dot | None:
    value = row[metric]
    if value is None:
        return None
    scale, ends = _scale(metric), row.interval(metric)
    scaled = ends and (scale * ends.low, scale * ends.high)
    style, weather = order.style(row.driver), order.weathers.index(row.weather)
    return interval_chart.Dot(shown(row.scenario), row.driver, weather, style, scale * value, scaled)


def _marks(rows: Sequence[Row], order: Order, metric: Metric) -> list[interval_chart.Mark]:
    scale = _scale(metric)
    found = {row.cell[:2]: scale * row.paper[metric.paper] for row in rows if row.paper and metric.paper}
    return [
        interval_chart.Mark(shown(scenario), order.weathers.index(weather), value)
        for (scenario, weather), value in found.items()
    ]
