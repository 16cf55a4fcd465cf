"""The report of a run: one HTML file that needs nothing else, and no script to be read."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.resources import files
from itertools import groupby
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from vpf_sim.errors import InputError
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.run_folder import stored_plan
from vpf_sim.report import answer, clips, commands, dots, paths, tables
from vpf_sim.report.cells import MAIN, Order, Row, at, groups, interval_of, shown
from vpf_sim.report.chart import legend_key
from vpf_sim.report.paths import Chart, Track
from vpf_sim.report.places import places
from vpf_sim.report.stored_run import Record, StoredRun

MOST_TRACKS = 30  # seeds whose paths are drawn
MOST_PATH_CELLS = 12
MOST_COMMAND_CELLS = 6
MOST_LISTED = 40
DOTS = (  # key, title, scale, ends of the axis
    ("success_rate", "Episodes that reached the goal, %", 100.0, (0.0, 100.0)),
    ("path_mse_m2", "Path MSE, m²", 1.0, None),
    ("accuracy.shadow.throttle.range", "Throttle accuracy, % (range, shadow)", 100.0, (0.0, 100.0)),
    ("accuracy.shadow.steering.range", "Steering accuracy, % (range, shadow)", 100.0, (0.0, 100.0)),
    ("driving_score_2_1", "CARLA driving score 2.1", 1.0, (0.0, 1.0)),
    ("min_clearance_m", "Least clearance of an episode, mean, m", 1.0, None),
)
PAPER_KEYS = {
    "path_mse_m2": "path_mse_m2",
    "accuracy.shadow.throttle.range": "throttle",
    "accuracy.shadow.steering.range": "steering",
}
Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Section:
    """Charts that belong together."""

    title: str
    charts: tuple[Chart, ...]
    drivers: tuple[str, ...] = ()


def make(run: StoredRun, clip_count: int, tell: Tell) -> str:
    """The page as HTML; `tell` hears what is being done."""
    plan = stored_plan(run.path)
    order = Order(plan.scenario, plan.weather, plan.driver)
    jobs = plan.jobs()
    planned = {job.id for job in jobs}
    records = {key: record for key, record in run.records.items() if key in planned}
    summary = run.summary(jobs)
    rows: list[Row] = summary["rows"]
    failures = _failures(records, order)
    tell("drawing the paths and commands")
    path_sections, command_sections = _sections(run, order, records)
    chosen = clips.choose(records.values(), order.drivers, clip_count)
    films = []
    for number, record in enumerate(chosen, start=1):
        tell(f"filming {record['id']}, clip {number} of {len(chosen)}")
        films.append(_clip(run, record, tell))
    return render(
        {
            "command": run.manifest.get("command", "sweep"),
            "plan": plan,
            "order": order,
            "question": answer.question(run.manifest.get("command", "sweep"), order),
            "answers": answer.sentences(rows, order),
            "driven": len(records),
            "planned": len(jobs),
            "columns": MAIN,
            "groups": groups(rows, order),
            "has_paper": any(row.get("paper") for row in rows),
            "paths": path_sections,
            "commands": command_sections,
            "dots": list(_dot_charts(rows, order)),
            "map": list(tables.success_map(jobs, records, order)),
            "signs": _signs(jobs, records),
            "sign_of": tables.SIGNS,
            "marks": dots.SIGNS,
            "weather_differences": tables.comparisons(summary.get("comparisons") or [], "weather", order),
            "driver_differences": tables.comparisons(summary.get("comparisons") or [], "driver", order),
            "perception": tables.perception(rows, order),
            "comfort": tables.comfort(list(records.values()), order),
            "compute": tables.compute(run.timing, list(records.values()), order),
            "hosts": sorted({str(time["host"]) for time in run.timing.values() if "host" in time}),
            "clips": [film for film in films if film],
            "failures": [(record, run.reason(record["id"])) for record in failures[:MOST_LISTED]],
            "unlisted": max(0, len(failures) - MOST_LISTED),
            "fingerprint": run.manifest["fingerprint"],
            "mixed": sorted({str(record["fingerprint"]) for record in records.values() if "fingerprint" in record}),
            "folder": str(run.path),
        }
    )


def render(content: dict[str, Any]) -> str:
    """The template filled."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.globals["key"] = legend_key
    environment.filters["shown"] = shown
    folder = files("vpf_sim.report")
    style = Markup(environment.from_string(folder.joinpath("report.css.jinja").read_text("utf-8")).render())
    template = environment.from_string(folder.joinpath("report.html.jinja").read_text("utf-8"))
    return template.render(style=style, **content)


def _sections(
    run: StoredRun, order: Order, records: dict[str, Record]
) -> tuple[list[Section], list[tuple[str, list[commands.CommandCharts]]]]:
    """Paths and commands of each scenario and weather."""
    drawn: list[Section] = []
    driven: list[tuple[str, list[commands.CommandCharts]]] = []
    for scenario, weather in list(order.cells())[:MOST_PATH_CELLS]:
        here = [record for record in records.values() if (record["scenario"], record["weather"]) == (scenario, weather)]
        seeds = sorted({int(record["seed"]) for record in here})[:MOST_TRACKS]
        tracks = _tracks(run, order, [record for record in here if record["seed"] in seeds])
        if not tracks:
            continue
        where = places(scenario, seeds)
        title = f"{shown(scenario)}, {shown(weather)}"
        present = {record["driver"] for record in here}
        drivers = tuple(driver for driver in order.drivers if driver in present)
        drawn.append(Section(title, tuple(paths.charts(where, tracks, title)), drivers))
        if len(driven) < MOST_COMMAND_CELLS:
            first = [record for record in here if record["seed"] == seeds[0] and record["driver"] != "pid"]
            driven.append((title, _commands(run, order, first)))
    return drawn, [(title, charts) for title, charts in driven if charts]


def _tracks(run: StoredRun, order: Order, records: Sequence[Record]) -> list[Track]:
    """Drawn in this order: the first driver's lie on top."""
    found = []
    for record in sorted(records, key=order.place, reverse=True):
        table = run.steps(record["id"])
        if table is not None:
            style = order.style(record["driver"])
            found.append(Track(record["seed"], style, record["status"] == "success", table))
    return found


def _commands(run: StoredRun, order: Order, records: Sequence[Record]) -> list[commands.CommandCharts]:
    charts = []
    for record in sorted(records, key=order.place):
        table = run.steps(record["id"])
        if table is not None:
            charts.append(commands.charts(record["driver"], record["id"], order.style(record["driver"]), table))
    return charts


def _dot_charts(rows: Sequence[Row], order: Order) -> Iterator[Chart]:
    """One a score, with the paper's values where it has them."""
    for key, title, scale, ends in DOTS:
        found = [dot for row in sorted(rows, key=order.place) if (dot := _dot(row, key, scale, order))]
        if found:
            yield Chart(title, dots.chart(found, _marks(rows, order, PAPER_KEYS.get(key), scale), title, ends))


def _dot(row: Row, key: str, scale: float, order: Order) -> dots.Dot | None:
    value, grey = at(row, key), False
    if value is None:
        value, grey = at(row.get("unsuccessful") or {}, key), True
    if value is None:
        return None
    weather = order.weathers.index(row["weather"])
    ends = None if grey else interval_of(row, key)
    scaled = ends and (scale * ends[0], scale * ends[1])
    return dots.Dot(
        shown(row["scenario"]), row["driver"], weather, order.style(row["driver"]), scale * value, scaled, grey
    )


def _marks(rows: Sequence[Row], order: Order, key: str | None, scale: float) -> list[dots.Mark]:
    if key is None:
        return []
    found = {(row["scenario"], row["weather"]): scale * row["paper"][key] for row in rows if row.get("paper")}
    return [
        dots.Mark(shown(scenario), order.weathers.index(weather), value) for (scenario, weather), value in found.items()
    ]


def _clip(run: StoredRun, record: Record, tell: Tell) -> clips.Clip | None:
    """A film, unless what it would show is no longer there, such as a scenario's file."""
    with suppress(InputError):
        return clips.make(run, record)
    tell(f"{record['id']} cannot be drawn again: its scenario, weather or driver is not to be had here")
    return None


def _failures(records: dict[str, Record], order: Order) -> list[Record]:
    failed = [record for record in records.values() if record["status"] != "success"]
    return sorted(failed, key=lambda record: (*order.place(record), record["seed"]))


def _signs(jobs: Sequence[Job], records: dict[str, Record]) -> list[tuple[str, str, int]]:
    """(status, sign, how often) of what is on the success map."""
    found = sorted(records[job.id]["status"] if job.id in records else "missing" for job in jobs)
    counts = {status: len(list(group)) for status, group in groupby(found)}
    return [(status, sign, counts[status]) for status, sign in tables.SIGNS.items() if status in counts]
