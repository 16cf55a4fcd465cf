"""Charts of paths: overview, zooms at obstacles, and offset from the lane's centre over distance."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting.kit.chart import Axis, Figure, Plot, reach, thinned
from vpf_sim.reporting.road_layout import RoadLayout, StaticObstacle
from vpf_sim.types import Floats

WIDTH, TALLEST = 360.0, 290.0
ZOOM_M, ZOOM_HEIGHT = 54.0, 150.0  # along the road; px across it
MOST_ZOOMS = 3
EVERY_M = 1.5  # along a path
Turn = Callable[[Floats], Floats]  # from the world to the axes of a plot


@dataclass(frozen=True, slots=True)
class Track:
    """The path of one episode."""

    seed: int
    style: str  # of its driver
    succeeded: bool
    table: StepTable


def charts(layouts: Mapping[int, RoadLayout], tracks: Sequence[Track], title: str) -> list[Figure]:
    """The charts of one scenario in one weather; if each seed has its own road, the maps show the first seed."""
    first = layouts[min(layouts)]
    alike = {seed: layout for seed, layout in layouts.items() if layout.has_the_road_of(first)}
    one_road = len(alike) == len(layouts)
    shown = alike if one_road else {min(layouts): first}
    here = [track for track in tracks if track.seed in shown]
    which = "" if one_road else f", seed {min(layouts)} (each seed has its own road)"
    obstacles = [obstacle for layout in layouts.values() for obstacle in layout.static_obstacles] if one_road else []
    maps = [
        Figure(f"Overview{which}; world axes, m.", overview(first, list(shown.values()), here, title)),
        Figure(_offset_caption(layouts, one_road), offsets(layouts, obstacles, tracks, title)),
    ]
    for number, (s_m, what) in enumerate(zooms(list(shown.values()))[:MOST_ZOOMS], start=1):
        caption = f"Zoom {number}: {what}{which}; driving to the right, to scale."
        maps.append(Figure(caption, zoom(first, list(shown.values()), here, s_m, title)))
    return maps


def overview(layout: RoadLayout, layouts: Sequence[RoadLayout], tracks: Sequence[Track], title: str) -> Markup:
    """The carriageway and all paths in world axes, x to the right, y down."""
    line = np.concatenate([*layout.lines.solid_m, *layout.lines.dashed_m, layout.route_line_m])
    low, high = line.min(axis=0) - 6.0, line.max(axis=0) + 6.0
    margins = (40.0, 8.0, 8.0, 30.0)
    inner = WIDTH - margins[0] - margins[1]
    scale = min(inner / (high[0] - low[0]), (TALLEST - 38.0) / (high[1] - low[1]))
    height = max(scale * (high[1] - low[1]), 90.0)
    centre, half = 0.5 * (low + high), 0.5 * np.array([inner, height]) / scale
    plot = Plot(
        WIDTH,
        height + margins[2] + margins[3],
        Axis(centre[0] - half[0], centre[0] + half[0], "x, m"),
        Axis(centre[1] + half[1], centre[1] - half[1], "y, m"),
        margins,
    )
    plot.grid()
    _road(plot, layout, np.asarray)
    _draw_obstacles(plot, layouts, np.asarray)
    for track in tracks:
        points = _sampled(track.table, 2.0 * EVERY_M)
        plot.line(points[:, 0], points[:, 1], f"path {track.style}")
    _ends(plot, layout)
    return plot.svg(f"{title}: paths over the road, overview")


def zooms(layouts: Sequence[RoadLayout]) -> list[tuple[float, str]]:
    """(s, caption) of each zoom: rows of obstacles in driving order."""
    spots = sorted(obstacle.s_m for obstacle in layouts[0].static_obstacles)
    rows: list[float] = []
    for s_m in spots:
        if not rows or abs(s_m - rows[-1]) > 0.5 * ZOOM_M:
            rows.append(s_m)
    names = ("the first obstacle", "the second obstacle", "the third obstacle")
    return [(s_m, names[number] if number < len(names) else "") for number, s_m in enumerate(rows)]


def zoom(layout: RoadLayout, layouts: Sequence[RoadLayout], tracks: Sequence[Track], s_m: float, title: str) -> Markup:
    """A section of the road, rotated so that driving goes to the right."""
    centre = np.array(layout.centre.position_at(s_m, 0.0))
    heading = layout.centre.heading_at(s_m)
    along, right = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    turn = np.stack([along, right], axis=1)
    half = 0.5 * ZOOM_M
    across = half * ZOOM_HEIGHT / WIDTH
    plot = Plot(WIDTH, ZOOM_HEIGHT, Axis(-half, half), Axis(across, -across), (0.0, 0.0, 0.0, 0.0))

    def local(points_m: Floats) -> Floats:
        turned: Floats = (points_m - centre) @ turn
        return turned

    _road(plot, layout, local)
    _draw_obstacles(plot, layouts, local)
    for track in tracks:
        points = local(_sampled(track.table, EVERY_M / 2.0))
        near = np.abs(points[:, 0]) < half + 4.0
        points = np.where(near[:, None], points, np.nan)
        plot.line(points[:, 0], points[:, 1], f"path {track.style}")
        if not track.succeeded and near[-1]:
            _cross(plot, float(points[-1, 0]), float(points[-1, 1]), track.style)
    _scale(plot, half, across)
    return plot.svg(f"{title}: paths over the road, zoom at {s_m:.0f} m of the carriageway")


def offsets(
    layouts: Mapping[int, RoadLayout], obstacles: Sequence[StaticObstacle], tracks: Sequence[Track], title: str
) -> Markup:
    """The offset from the lane's centre over the distance driven; left is up.

    Edges are drawn where all places have them.
    """
    left, right = _sides(obstacles, tracks)
    plot = Plot(
        WIDTH,
        200.0,
        Axis(0.0, max(layout.route.length_m for layout in layouts.values()), "distance, m"),
        Axis(right, left, "m right of the lane's centre"),
    )
    plot.grid()
    length = plot.x.high
    for edge in set.intersection(*(set(layout.edges_m) for layout in layouts.values())):
        if left < edge < right:
            plot.line(np.array([0.0, length]), np.array([edge, edge]), "edge")
    plot.line(np.array([0.0, length]), np.zeros(2), "centre")
    for obstacle in obstacles:
        x, y = np.array(obstacle.route_m)[[0, 1, 1, 0]], np.array(obstacle.offset_m)[[0, 0, 1, 1]]
        plot.line(x, np.clip(y, left, right), "obstacle", closed=True)
    for track in tracks:
        x, y = thinned(track.table.route_m, track.table.lane_offset_m, 90)
        plot.line(x, np.where((y >= left) & (y <= right), y, np.nan), f"path {track.style}")
        if not track.succeeded:
            _cross(plot, float(track.table.route_m[-1]), float(track.table.lane_offset_m[-1]), track.style)
    return plot.svg(f"{title}: offset from the lane's centre over distance")


def _sides(obstacles: Sequence[StaticObstacle], tracks: Sequence[Track]) -> tuple[float, float]:
    """The range of offsets to show: that of the obstacles and the successful drives."""
    found = [track.table.lane_offset_m for track in tracks if track.succeeded] or [np.zeros(1)]
    sides = [side for obstacle in obstacles for side in obstacle.offset_m]
    left, right = reach([0.0, *sides, *(float(end) for one in found for end in (one.min(), one.max()))], 2.0)
    return max(left, -12.0), min(right, 12.0)


def _offset_caption(layouts: Mapping[int, RoadLayout], one_road: bool) -> str:
    caption = "Offset from the lane's centre over distance, across the road enlarged; × is where an episode failed."
    if not one_road:
        return f"{caption} Each seed has its own road and obstacles, which are not drawn."
    return (
        f"{caption} Moving cars are not drawn." if any(layout.has_traffic for layout in layouts.values()) else caption
    )


def _sampled(table: StepTable, every_m: float) -> Floats:
    """(M, 2) m, the path resampled about every `every_m`."""
    points = table.positions_m
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    count = max(2, int(driven[-1] / every_m) + 1)
    wanted = np.linspace(0.0, driven[-1], count)
    return np.stack([np.interp(wanted, driven, points[:, axis]) for axis in (0, 1)], axis=1)


def _road(plot: Plot, layout: RoadLayout, local: Turn) -> None:
    lines = layout.lines
    for left, right in lines.strips_m:
        whole = local(np.concatenate([left, right[::-1]]))
        plot.line(whole[:, 0], whole[:, 1], "asphalt", closed=True)
    for style, found in (("dash", lines.dashed_m), ("edge", lines.solid_m)):
        for line in map(local, found):
            plot.line(line[:, 0], line[:, 1], style)
    route = local(layout.route_line_m)
    plot.line(route[:, 0], route[:, 1], "centre")


def _draw_obstacles(plot: Plot, layouts: Sequence[RoadLayout], local: Turn) -> None:
    for layout in layouts:
        for obstacle in layout.static_obstacles:
            corners = local(obstacle.corners_m)
            plot.line(corners[:, 0], corners[:, 1], "obstacle", closed=True)


def _ends(plot: Plot, layout: RoadLayout) -> None:
    start, goal = layout.route_line_m[0], layout.route_line_m[-1]
    plot.dot(start[0], start[1], "start")
    plot.dot(goal[0], goal[1], "goal")
    for words, (x, y) in (("start", start), ("goal", goal)):
        px, py = plot.place(float(x), float(y))
        side = "end" if px > 0.75 * plot.width else "start"
        plot.text(words, float(px) + (-7.0 if side == "end" else 7.0), float(py) - 9.0, "label", side)


def _scale(plot: Plot, half: float, across: float) -> None:
    """Draw a scale bar of ten metres."""
    y = across - 1.4
    plot.line(np.array([-half + 2.0, -half + 12.0]), np.array([y, y]), "bar")
    plot.text_at("10 m", -half + 13.0, y + 0.6, "tick")


def _cross(plot: Plot, x: float, y: float, style: str) -> None:
    px, py = plot.place(x, np.clip(y, min(plot.y.low, plot.y.high), max(plot.y.low, plot.y.high)))
    plot.text("×", float(px), float(py) + 5.0, f"cross {style}", "middle")
