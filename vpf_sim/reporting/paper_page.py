"""The page that compares a run with the paper: its table, definitions, claims and figures."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from vpf_sim.evaluation.analysis import reproduction
from vpf_sim.evaluation.analysis.benchmark import SCENARIOS
from vpf_sim.evaluation.analysis.paper_claims import Claim, claims
from vpf_sim.evaluation.analysis.reproduction import CELLS, REFERENCE_DRIVER, SIGNALS, CellResult, Definition, Drive
from vpf_sim.evaluation.job import Job
from vpf_sim.files import write_bytes, write_text
from vpf_sim.reporting import paper_figures
from vpf_sim.reporting.kit.clip import data_uri
from vpf_sim.reporting.kit.page import render
from vpf_sim.reporting.kit.table import NONE, Cell, Table, Value, formatted
from vpf_sim.reporting.redraw import Redrawing
from vpf_sim.reporting.road_layout import layouts
from vpf_sim.reporting.stored_run import StoredRun

JSON, PAGE = "paper.json", "paper.html"
NO_OBSTACLE_M = 40.0  # along the route, where to take the picture on a road without obstacles
PATH_HEADER = (
    *("condition", "reached", "MSE, m²: the paper's", "ours, to the lane's centre", "to the PID's path"),
    *("least clearance, m", "within one lane, %", "mean yaw acceleration, rad/s²"),
)
PATH_NOTES = ("Means over the drives that reached the goal.",)
ACCURACY_NOTES = (
    "The paper prints throttle 82.34, 78.51, 78.45, 70.76 % and steering 72.14, 71.67, 67.12, 65.45 %, without a "
    "formula. By each definition, in the same order; d is the difference to the PID's command. “Off” is the mean "
    "deviation from print.",
    "Shadow: the PID's command at every state that the driver visited. Paired: the PID's own run, matched by distance.",
)
FIGURES = {  # title, and meaning for screen readers
    "paths": ("Paths", "Paths in the four conditions"),
    "flow": ("Flow and obstacle map", "Flow and obstacle map in clear weather and in rain"),
    "forces": ("Forces along the route", "Lateral forces along the route"),
}


@dataclass(frozen=True, slots=True)
class Answer:
    """The content of paper.json."""

    driver: str
    cells: list[CellResult]
    definitions: list[Definition]
    claims: list[Claim]


def drives_of(run: StoredRun, driver: str) -> list[Drive]:
    """The episodes of a driver, each with the PID's on the same seed without obstacles: the planned trajectory."""
    found = []
    for record in run.records.values():
        table = run.steps(record.id)
        if record.driver == driver and table is not None:
            pid = run.steps(Job(SCENARIOS[0], record.weather, REFERENCE_DRIVER, record.seed).id)
            found.append(Drive(record.scenario, record.weather, record, table, pid))
    return found


def answer(run: StoredRun, driver: str, drives: list[Drive]) -> Answer:
    """The tables and claims of a run."""
    rows = reproduction.cells(drives)
    timing = [run.timing[drive.record.id] for drive in drives if drive.record.id in run.timing]
    times = [time.stages_ms["driver"] for time in timing if "driver" in time.stages_ms]
    found = claims(rows, drives, float(np.median(times)) if times else None)
    return Answer(driver, rows, reproduction.definitions(rows), found)


def write(folder: Path, drives: list[Drive], found: Answer) -> Path:
    """Write paper.json, the figures as PNG files, and the page with all of it; the page's path."""
    figures = _figures(drives)
    for name, picture in figures.items():
        write_bytes(folder / f"{name}.png", picture)
    write_text(folder / JSON, json.dumps(asdict(found), indent=2, allow_nan=False))
    write_text(folder / PAGE, page(found, figures))
    return folder / PAGE


def page(found: Answer, figures: Mapping[str, bytes]) -> str:
    """The page as HTML; `figures` are PNG files by name."""
    drawn = [(*FIGURES[name], data_uri("image/png", figure)) for name, figure in figures.items()]
    title = f"The paper's simulator table, and {found.driver}"
    return render("paper.html.jinja", title=title, tables=tables(found), pictures=drawn)


def tables(found: Answer) -> tuple[Table, Table, Table]:
    """The paths, the claims, and the accuracies by each definition."""
    columns = [column for signal in SIGNALS for column in (f"{signal}, %", "off, points", "same order")]
    return (
        Table(PATH_HEADER, tuple(map(_path, found.cells)), title="Path", notes=PATH_NOTES),
        Table(
            ("claim", "measured", "holds"),
            tuple((one.claim, one.measured, one.verdict) for one in found.claims),
            words=3,
            title="The paper's claims",
        ),
        Table(
            ("definition", "protocol", *columns),
            tuple(map(_definition, found.definitions)),
            words=2,
            title="Accuracy",
            notes=ACCURACY_NOTES,
        ),
    )


def _path(row: CellResult) -> tuple[Cell, ...]:
    errors = (row.paper["path_mse_m2"], row.lane_mse_m2, row.path_mse_m2.get("PID's path"), row.clearance_m)
    return (
        f"{row.weather}, {row.scenario}",
        f"{row.successes} of {row.episodes}",
        *(Value(formatted(value, 2), value=value) for value in errors),
        Value(formatted(row.in_lane_share, 1, True), value=row.in_lane_share),
        Value(formatted(row.jerkiness_radps2, 3), value=row.jerkiness_radps2),
    )


def _definition(row: Definition) -> tuple[Cell, ...]:
    cells: list[Cell] = [row.formula, row.protocol]
    for one in (row.throttle, row.steering):
        order = {True: "yes", False: "no", None: NONE}[one.same_order]
        cells += [", ".join(formatted(value, 1, True) for value in one.values), formatted(one.off, 1), order]
    return tuple(cells)


def _figures(drives: list[Drive]) -> dict[str, bytes]:
    seeds = {scenario: sorted({one.record.seed for one in drives if one.scenario == scenario}) for scenario, _ in CELLS}
    where = {
        (scenario, seed): layout for scenario, some in seeds.items() for seed, layout in layouts(scenario, some).items()
    }
    found = {}
    for cell in CELLS:
        here = [drive for drive in drives if (drive.scenario, drive.weather) == cell]
        shown = min(here, key=lambda drive: (not drive.succeeded, drive.record.seed), default=None)
        if shown is not None:
            obstacles = where[cell[0], shown.record.seed].static_obstacles
            face_m = min((obstacle.route_m[0] for obstacle in obstacles), default=NO_OBSTACLE_M)
            drawing = Redrawing(shown.record, shown.table, replan=True)
            found[cell] = paper_figures.forces_along(drawing, face_m)
    return {
        "paths": paper_figures.paths(drives, where),
        "flow": paper_figures.flow(found),
        "forces": paper_figures.forces(found),
    }
