"""Views of a plan: the lateral cost from above with its minimum, and a motion in the frame with what was rejected."""

import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.planning.lane.frame import LaneObstacles
from vpf_sim.planning.lane.lateral_cost import CostProfile
from vpf_sim.planning.lane.planner import LanePlan
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.reporting.canvas import INK, Canvas, Colour
from vpf_sim.reporting.top_view import OBSTACLE, REFERENCE, ROAD, TARGET
from vpf_sim.types import Camera, Floats, Image, Plan

AHEAD_M = 45.0
MARGIN_M = 1.0  # beyond the carriageway's edges
PROFILE_SHARE = 0.32  # of the picture's height, for the curves
HIGHEST = 12.0  # cost at the top of the curves and of the tint
PAPER: Colour = (28, 33, 40)
PATH: Colour = (120, 255, 150)
BROKEN: Colour = (255, 92, 72)  # of a motion that breaks a limit, as all others do
CAR_WIDTH_M = 1.9
FIRST_ROW, ROW = 62.0, 14.0  # of the words, below those of the speed


def draw(plan: Plan, width_px: int = 640, height_px: int = 480) -> Image:
    """(H, W, 3) RGB view of a plan of the lane planner; InputError for another plan."""
    details = plan.extra
    if not isinstance(details, LanePlan):
        raise InputError("cost view: expected a plan with a lateral cost, as of the driver vpf")
    lane, cost = details.lane, details.cost
    canvas = Canvas(np.full((height_px, width_px, 3), PAPER, np.uint8), Camera(width_px, height_px))
    base = (1.0 - PROFILE_SHARE) * height_px
    view = _View(lane.left_m - MARGIN_M, lane.right_m + MARGIN_M, width_px, base)
    _tint(canvas, view, cost.y_m, cost.total)
    _edges(canvas, view, lane.left_m, lane.right_m)
    _draw_obstacles(canvas, view, details.obstacles)
    _vehicle(canvas, view, lane.y_m)
    _curves(canvas, view, cost)
    _minimum(canvas, view, cost.minimum_m, details.reference_y_m)
    _legend(canvas)
    return canvas.frame


class _View:
    """Maps lane coordinates to pixels: y to the right, along the road upwards."""

    def __init__(self, left_m: float, right_m: float, width_px: int, base_px: float) -> None:
        self.left_m, self.scale, self.base_px = left_m, width_px / (right_m - left_m), base_px
        self.ahead = (base_px - 12.0) / AHEAD_M

    def place(self, y_m: Floats, along_m: Floats) -> Floats:
        return np.stack([(y_m - self.left_m) * self.scale, self.base_px - along_m * self.ahead], axis=-1)

    def across(self, y_m: float, low: float, high: float) -> Floats:
        """(2, 2) px, a line along the road at y."""
        return self.place(np.array([y_m, y_m]), np.array([low, high]))


def _tint(canvas: Canvas, view: _View, y_m: Floats, total: Floats) -> None:
    """Colour the road by the cost, dark where it is low."""
    columns = view.left_m + (np.arange(canvas.frame.shape[1]) + 0.5) / view.scale
    height = np.clip(np.interp(columns, y_m, total) / HIGHEST, 0.0, 1.0)
    levels = np.asarray(np.rint(215.0 * np.sqrt(height)), np.uint8)[None]  # below the brightest end of the colour map
    colours = cv2.cvtColor(cv2.applyColorMap(levels, cv2.COLORMAP_INFERNO), cv2.COLOR_BGR2RGB)
    canvas.frame[: int(view.base_px)] = colours


def _edges(canvas: Canvas, view: _View, left_m: float, right_m: float) -> None:
    for y in (left_m, right_m):
        canvas.lines([view.across(y, 0.0, AHEAD_M)], ROAD, 2)


def _draw_obstacles(canvas: Canvas, view: _View, obstacles: LaneObstacles) -> None:
    """Draw obstacles from their estimated face, with a fixed length."""
    for along, left, right in zip(obstacles.along_m, obstacles.left_m, obstacles.right_m, strict=True):
        y, x = np.array([left, right, right, left]), along + np.array([0.0, 0.0, 4.0, 4.0])
        if along > AHEAD_M:
            continue
        box = view.place(y, np.minimum(x, AHEAD_M))
        canvas.fill([box], OBSTACLE, 0.75)
        canvas.lines([box], INK, 1, closed=True)


def _vehicle(canvas: Canvas, view: _View, y_m: float) -> None:
    place = view.place(
        np.array([y_m - 0.95, y_m + 0.95, y_m + 0.95, y_m, y_m - 0.95]), np.array([0.0, 0.0, 2.0, 3.5, 2.0])
    )
    canvas.fill([place], INK, 1.0)


def _curves(canvas: Canvas, view: _View, cost: CostProfile) -> None:
    """Plot U(y) below the road: its three parts and their sum."""
    bottom = canvas.frame.shape[0] - 8.0
    for values, colour, width in (
        (cost.target, TARGET, 1),
        (cost.road, ROAD, 1),
        (cost.obstacle, OBSTACLE, 1),
        (cost.total, INK, 2),
    ):
        height = np.clip(values / HIGHEST, 0.0, 1.0) * (bottom - view.base_px - 16.0)
        x = (cost.y_m - view.left_m) * view.scale
        canvas.lines([np.stack([x, bottom - height], axis=1)], colour, width)


def _minimum(canvas: Canvas, view: _View, minimum_m: float, reference_m: float) -> None:
    canvas.lines([view.across(reference_m, 0.0, AHEAD_M)], REFERENCE, 2)
    x = float(view.place(np.array(minimum_m), np.array(0.0))[0])
    bottom = canvas.frame.shape[0] - 4.0
    canvas.lines([np.array([[x, view.base_px], [x, bottom]])], REFERENCE, 1)
    canvas.disc(np.array([x, bottom - 4.0]), 4.0, REFERENCE)


def _legend(canvas: Canvas) -> None:
    left = 12.0
    for word, colour in (
        ("cost: goal", TARGET),
        ("+ road", ROAD),
        ("+ obstacles", OBSTACLE),
        ("minimum", REFERENCE),
    ):
        canvas.text(word, left, 22.0, colour, 0.42)
        left += canvas.text_width_px(word) + 14.0


def draw_motion(canvas: Canvas, plan: MotionPlan) -> None:
    """Draw the path of the next seconds on the road, and the number of rejected candidates by reason."""
    colour = BROKEN if plan.motion.is_rejected else PATH
    left, right = (canvas.project(side) for side in _sides(plan))
    near = np.all(np.isfinite(left) & np.isfinite(right), axis=1)
    canvas.fill([np.concatenate([left[near], right[near][::-1]])], colour, 0.5, top_opacity=0.15)
    for row, words in enumerate(reasons(plan)):
        canvas.text(words, 12 * canvas.unit, (FIRST_ROW + ROW * row) * canvas.unit, INK, 0.32)


def reasons(plan: MotionPlan) -> list[str]:
    """The number of rejected candidates by reason, most first: "collision 675"."""
    counts = sorted(plan.motion.rejected._asdict().items(), key=lambda one: -one[1])
    return [f"{reason.replace('_', ' ')} {count}" for reason, count in counts if count]


def _sides(plan: MotionPlan) -> tuple[Floats, Floats]:
    """(N, 2) m, vehicle axes: the left and the right side of the path."""
    points = plan.points_m()
    points = points[np.concatenate([[True], np.hypot(*np.diff(points, axis=0).T) > 1e-3])]
    if len(points) < 2:
        return points, points
    ahead = np.gradient(points, axis=0)
    across = 0.5 * CAR_WIDTH_M * np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1) / np.hypot(*ahead.T)[:, None]
    return points - across, points + across
