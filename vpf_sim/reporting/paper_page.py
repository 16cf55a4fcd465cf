"""The page that compares a run with the paper: its table, definitions, claims and figures."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vpf_sim.evaluation.analysis import reproduction
from vpf_sim.evaluation.analysis.benchmark import SCENARIOS
from vpf_sim.evaluation.analysis.paper_claims import Claim, claims
from vpf_sim.evaluation.analysis.reproduction import CELLS, REFERENCE_DRIVER, SIGNALS, CellResult, Definition, Drive
from vpf_sim.evaluation.job import Job
from vpf_sim.files import write_bytes, write_text
from vpf_sim.reporting.kit.clip import data_uri
from vpf_sim.reporting.kit.page import NONE, Cell, Table, Value, formatted, render
from vpf_sim.reporting.redraw import Moment, Redrawing
from vpf_sim.reporting.road_layout import RoadLayout, StaticObstacle, layouts
from vpf_sim.reporting.run_data import StoredRun
from vpf_sim.types import Floats

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
matplotlib.use("agg")  # no display
ZOOM_M = 45.0  # of the route, in the close view
FLOW_FIGURE_M = 12.0  # from the bumper to the obstacle in the figure of the flow
OWN, PLANNED, OBSTACLE, EDGE = "#c2410c", "#1d4ed8", "#444444", "#9ca3af"
FORCES = {"target": "#15803d", "obstacle": "#c2410c", "road": "#1d4ed8"}
NAMES = {"town04-clean": "no obstacles", "town04": "obstacles", "clear": "clear", "rain": "hard rain"}


@dataclass(frozen=True, slots=True)
class Along:
    """The driver's forces along one episode, and one moment before the first obstacle."""

    route_m: Floats  # (n,)
    forces: Mapping[str, Floats]  # "target", "obstacle", "road" -> (n, 2) in vehicle axes
    moment: Moment | None  # before the first obstacle


def forces_along(drawing: Redrawing, first_face_m: float) -> Along:
    """Recompute the driver's plans; the moment is FLOW_FIGURE_M before `first_face_m` of the route."""
    route, forces, moment = [], [], None
    for one in drawing.moments():
        here = float(drawing.table.route_m[one.index])
        if one.plan is not None:
            route.append(here)
            forces.append([getattr(one.plan.force, name) for name in FORCES])
            if moment is None and here >= first_face_m - FLOW_FIGURE_M:
                moment = one
    stacked = np.array(forces).reshape(-1, len(FORCES), 2)
    return Along(np.array(route), {name: stacked[:, i] for i, name in enumerate(FORCES)}, moment)


def paths(drives: Sequence[Drive], layouts: Mapping[tuple[str, int], RoadLayout]) -> bytes:
    """PNG of the paths in the four conditions, overview and detail, as in the paper's figures."""
    figure = Figure(figsize=(11.0, 13.0), layout="constrained")
    axes = figure.subplots(len(CELLS), 2, squeeze=False)
    for (scenario, weather), (whole, near) in zip(CELLS, axes, strict=True):
        here = [drive for drive in drives if (drive.scenario, drive.weather) == (scenario, weather)]
        layout = next((layouts[scenario, drive.record.seed] for drive in here), None)
        if layout is None:
            continue
        obstacles = layout.static_obstacles
        middle = _middle(layout, obstacles)
        for axis in (whole, near):
            _road(axis, layout, obstacles)
            for drive in here:
                axis.plot(drive.table.x_m, drive.table.y_m, color=OWN, linewidth=1.1, alpha=0.8)
            axis.set_aspect("equal")
            axis.invert_yaxis()
        whole.set_title(f"{NAMES[weather]}, {NAMES[scenario]}", fontsize=10)
        near.set_title("detail", fontsize=10)
        near.set_xlim(middle[0] - 0.5 * ZOOM_M, middle[0] + 0.5 * ZOOM_M)
        near.set_ylim(middle[1] + 0.25 * ZOOM_M, middle[1] - 0.25 * ZOOM_M)
        whole.set_ylabel("y, m")
    for axis in axes[-1]:
        axis.set_xlabel("x, m")
    figure.legend(
        handles=[
            *axes[0][0].plot([], [], color=OWN, label="driven"),
            *axes[0][0].plot([], [], color=PLANNED, linestyle="--", label="planned: the lane's centre"),
            *axes[0][0].plot([], [], color=EDGE, label="lane lines and edges"),
        ],
        loc="outside lower center",
        ncols=3,
    )
    return _png(figure)


def forces(found: Mapping[tuple[str, str], Along]) -> bytes:
    """PNG of the lateral component of each force along the route; + is to the right."""
    figure = Figure(figsize=(11.0, 10.0), layout="constrained")
    axes = figure.subplots(len(CELLS), 1, sharex=True, squeeze=False)[:, 0]
    for cell, axis in zip(CELLS, axes, strict=True):
        axis.set_title(f"{NAMES[cell[1]]}, {NAMES[cell[0]]}", fontsize=10)
        axis.axhline(0.0, color=EDGE, linewidth=0.8)
        if cell not in found:
            continue
        for name, colour in FORCES.items():
            axis.plot(found[cell].route_m, found[cell].forces[name][:, 1], color=colour, linewidth=0.9, label=name)
        reach = np.percentile(np.abs(np.concatenate([one[:, 1] for one in found[cell].forces.values()])), 99.5)
        axis.set_ylim(-1.2 * reach - 1e-9, 1.2 * reach + 1e-9)
        axis.set_ylabel("force to the right")
    axes[0].legend(loc="upper right", ncols=3)
    axes[-1].set_xlabel("driven, m")
    return _png(figure)


def flow(found: Mapping[tuple[str, str], Along]) -> bytes:
    """PNG of flow and obstacle map before the first obstacle, in clear weather and in rain."""
    figure = Figure(figsize=(11.0, 8.6), layout="constrained")
    axes = figure.subplots(2, 2, squeeze=False)
    for column, weather in enumerate(("clear", "rain")):
        along = found.get(("town04", weather))
        moment = along.moment if along is not None else None
        for axis in axes[:, column]:
            axis.set_axis_off()
        seen = None if moment is None or moment.plan is None else moment.plan.perception
        if moment is None or seen is None:
            continue
        points, moved = seen.flow.points_px, seen.flow.displacement_px
        marked = seen.features.obstacle_map.on_obstacle
        axes[0, column].set_title(f"{NAMES[weather]}: flow over 0.1 s, obstacle points in red", fontsize=10)
        axes[0, column].imshow(moment.image)
        for chosen, colour in ((~marked, "#facc15"), (marked, "#ef4444")):
            axes[0, column].quiver(
                *(points - moved)[chosen].T, *moved[chosen].T, color=colour, angles="xy", scale_units="xy", scale=1.0,
                width=0.0025,
            )  # fmt: skip
        axes[0, column].plot(seen.expansion.x_px, seen.expansion.y_px, "c+", markersize=12, markeredgewidth=2)
        axes[1, column].set_title("obstacle map O", fontsize=10)
        axes[1, column].imshow(seen.features.obstacle_map.plane, cmap="gray", vmin=0.0, vmax=1.0)
    return _png(figure)


def _road(axis: Axes, layout: RoadLayout, obstacles: Sequence[StaticObstacle]) -> None:
    for line in (*layout.lines.solid_m, *layout.lines.dashed_m):
        axis.plot(line[:, 0], line[:, 1], color=EDGE, linewidth=0.8)
    route = layout.route_line_m
    axis.plot(route[:, 0], route[:, 1], color=PLANNED, linestyle="--", linewidth=1.0)
    for obstacle in obstacles:
        axis.fill(obstacle.corners_m[:, 0], obstacle.corners_m[:, 1], color=OBSTACLE)


def _middle(layout: RoadLayout, obstacles: Sequence[StaticObstacle]) -> tuple[float, float]:
    """The centre of the detail view: the first obstacle, or the middle of the route."""
    if obstacles:
        return min(obstacles, key=lambda obstacle: obstacle.s_m).centre_m
    route = layout.route_line_m
    x, y = route[len(route) // 2].tolist()
    return x, y


def _png(figure: Any) -> bytes:
    file = BytesIO()
    figure.savefig(file, format="png", dpi=110, metadata={"Software": None})
    return file.getvalue()


@dataclass(frozen=True, slots=True)
class Findings:
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


def findings(run: StoredRun, driver: str, drives: list[Drive]) -> Findings:
    """The tables and claims of a run."""
    rows = reproduction.cells(drives)
    timing = [run.timing[drive.record.id] for drive in drives if drive.record.id in run.timing]
    times = [time.stages_ms["driver"] for time in timing if "driver" in time.stages_ms]
    found = claims(rows, drives, float(np.median(times)) if times else None)
    return Findings(driver, rows, reproduction.definitions(rows), found)


def write(folder: Path, drives: list[Drive], found: Findings) -> Path:
    """Write paper.json, the figures as PNG files, and the page with all of it; the page's path."""
    figures = _figures(drives)
    for name, picture in figures.items():
        write_bytes(folder / f"{name}.png", picture)
    write_text(folder / JSON, json.dumps(asdict(found), indent=2, allow_nan=False))
    write_text(folder / PAGE, page(found, figures))
    return folder / PAGE


def page(found: Findings, figures: Mapping[str, bytes]) -> str:
    """The page as HTML; `figures` are PNG files by name."""
    drawn = [(*FIGURES[name], data_uri("image/png", figure)) for name, figure in figures.items()]
    title = f"The paper's simulator table, and {found.driver}"
    return render("paper.html.jinja", title=title, tables=tables(found), pictures=drawn)


def tables(found: Findings) -> tuple[Table, Table, Table]:
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
            found[cell] = forces_along(drawing, face_m)
    return {
        "paths": paths(drives, where),
        "flow": flow(found),
        "forces": forces(found),
    }
