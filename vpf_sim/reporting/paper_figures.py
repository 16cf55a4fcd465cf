"""The paper's figures from a run: paths, flow and obstacle map, and forces along the route."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vpf_sim.evaluation.analysis.reproduction import CELLS, Drive
from vpf_sim.reporting.redraw import Moment, Redrawing
from vpf_sim.reporting.road_layout import RoadLayout, StaticObstacle
from vpf_sim.types import Floats

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
        if moment is None or moment.plan is None:
            continue
        seen = moment.plan.perception
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
