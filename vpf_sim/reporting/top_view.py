"""Top view of the road, heading up, with a compass of the driver's forces and speed."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from vpf_sim.envs.network import RoadLines
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.reporting.canvas import INK, SHADE, Canvas, Colour
from vpf_sim.types import Bools, Camera, Floats, Force, Image, Plan

AHEAD_M = 52.0
BEHIND_M = 14.0
MEADOW: Colour = (38, 46, 42)
ASPHALT: Colour = (66, 70, 76)
MARKING: Colour = (150, 155, 160)
OBJECT: Colour = (214, 120, 92)
EGO: Colour = (92, 176, 255)
EGO_SIZE_M = (4.5, 1.9)
TARGET: Colour = (98, 214, 124)
OBSTACLE: Colour = (255, 92, 72)
ROAD: Colour = (92, 176, 255)
TOTAL: Colour = (255, 255, 255)
REFERENCE: Colour = (255, 208, 64)
RADIUS = 44.0  # px on a frame of 640


def draw_compass(canvas: Canvas, force: Force, ahead_rad: float) -> None:
    """Draw the compass in the lower right corner, with a legend; `ahead_rad` is the reference heading off the yaw."""
    radius = RADIUS * canvas.unit
    height, width = canvas.frame.shape[:2]
    centre = np.array([width - radius - 14 * canvas.unit, height - radius - 24 * canvas.unit])
    canvas.disc(centre, radius + 3 * canvas.unit, SHADE, 0.62)
    canvas.ring(centre, radius, (150, 160, 170), 1)
    for angle in np.arange(0.0, 2.0 * np.pi, np.pi / 2.0):
        canvas.lines([_ray(centre, angle, 0.9 * radius, radius)], (150, 160, 170), 1)
    arrows = ((force.target, TARGET), (force.road, ROAD), (force.obstacle, OBSTACLE), (force.total, TOTAL))
    longest = max(float(np.hypot(*vector)) for vector, _ in arrows)
    for vector, colour in arrows:
        length = float(np.hypot(*vector))
        if np.isfinite(length) and longest > 0.0 and length > 1e-3 * longest:
            # The square root keeps small forces visible beside large ones.
            _arrow(canvas, centre, np.arctan2(vector[1], vector[0]), 0.82 * radius * np.sqrt(length / longest), colour)
    _pointer(canvas, centre, ahead_rad, radius)
    _force_legend(canvas, centre, radius)


def _ray(centre: Floats, angle: float, inner: float, outer: float) -> Floats:
    """(2, 2) px from `inner` to `outer` in the direction `angle` (0 ahead, + right)."""
    way = np.array([sin(angle), -cos(angle)])
    return np.stack([centre + inner * way, centre + outer * way])


def _arrow(canvas: Canvas, centre: Floats, angle: float, length: float, colour: Colour) -> None:
    shaft = _ray(centre, angle, 0.0, length)
    head = 6.0 * canvas.unit
    barbs = [_ray(shaft[1], angle + np.pi + turn, 0.0, head)[1] for turn in (0.45, -0.45)]
    canvas.lines([shaft], SHADE, 4)
    canvas.lines([shaft], colour, 2)
    canvas.fill([np.stack([_ray(centre, angle, 0.0, length + 2.0 * canvas.unit)[1], *barbs])], colour, 1.0)


def _pointer(canvas: Canvas, centre: Floats, angle: float, radius: float) -> None:
    """Draw the reference heading as a wedge on the edge."""
    tip = _ray(centre, angle, 0.84 * radius, 0.84 * radius)[0]
    base = [_ray(centre, angle + side, 1.1 * radius, 1.1 * radius)[0] for side in (-0.13, 0.13)]
    wedge = np.stack([tip, *base])
    canvas.fill([wedge], REFERENCE, 1.0)
    canvas.lines([wedge], SHADE, 1, closed=True)


def _force_legend(canvas: Canvas, centre: Floats, radius: float) -> None:
    words = (("goal", TARGET), ("road", ROAD), ("obstacle", OBSTACLE))
    size = 0.32
    widths = [canvas.text_width_px(word, size) for word, _ in words]
    gap = 6 * canvas.unit
    left = float(centre[0]) - 0.5 * (sum(widths) + gap * (len(words) - 1))
    for (word, colour), width in zip(words, widths, strict=True):
        canvas.text(word, left, float(centre[1]) + radius + 15 * canvas.unit, colour, size)
        left += width + gap


@dataclass(frozen=True, slots=True)
class Rectangle:
    """The outline of an object in world axes."""

    x_m: float
    y_m: float
    heading_rad: float
    length_m: float
    width_m: float
    kind: str

    @property
    def corners_m(self) -> Floats:
        """(4, 2) m, the corners in order."""
        cosine, sine = np.cos(self.heading_rad), np.sin(self.heading_rad)
        along = 0.5 * self.length_m * np.array([cosine, sine])
        across = 0.5 * self.width_m * np.array([-sine, cosine])
        centre = np.array([self.x_m, self.y_m])
        return np.stack([centre + i * along + j * across for i, j in ((1, 1), (1, -1), (-1, -1), (-1, 1))])


@dataclass(frozen=True, slots=True)
class Scene:
    """The static scene in world axes."""

    lines: RoadLines
    route_m: Floats  # (M, 2)
    goal_m: tuple[float, float]


def draw(
    scene: Scene,
    objects: tuple[Rectangle, ...],
    trail_m: Floats,
    pose: Floats,
    plan: Plan | None,
    width_px: int,
    height_px: int,
) -> Image:
    """(H, W, 3) RGB top view; `trail_m` (N, 2) has past positions, `pose` (3,) is x m, y m, yaw rad."""
    canvas = Canvas(np.full((height_px, width_px, 3), MEADOW, np.uint8), Camera(width_px, height_px))
    view = _View(pose, width_px, height_px)
    _road(canvas, view, scene)
    canvas.lines([view.place(trail_m)], EGO, 2)
    for obj in objects:
        _rectangle(canvas, view, obj, OBJECT)
    if plan is not None:
        _perceived(canvas, view, plan)
    _goal(canvas, view, scene.goal_m)
    _legend(canvas, plan is not None)
    _rectangle(canvas, view, Rectangle(float(pose[0]), float(pose[1]), float(pose[2]), *EGO_SIZE_M, "car"), EGO)
    return canvas.frame


class _View:
    """Maps world axes to pixels: vehicle near the bottom, heading up."""

    def __init__(self, pose: Floats, width_px: int, height_px: int) -> None:
        self.scale = height_px / (AHEAD_M + BEHIND_M)
        self.centre_px = np.array([0.5 * width_px, self.scale * AHEAD_M])
        self.size_px = np.array([width_px, height_px])
        self.position_m, yaw = pose[:2], float(pose[2])
        # Columns: image x is to the right of the vehicle, image y is behind it.
        self.turn = np.array([[-np.sin(yaw), -np.cos(yaw)], [np.cos(yaw), -np.sin(yaw)]])

    def place(self, points_m: Floats) -> Floats:
        """(..., 2) px of (..., 2) m."""
        placed: Floats = (points_m - self.position_m) @ self.turn * self.scale + self.centre_px
        return placed

    def from_vehicle(self, points_m: Floats) -> Floats:
        """(..., 2) px of (..., 2) m in vehicle axes."""
        return self.centre_px + self.scale * np.stack([points_m[..., 1], -points_m[..., 0]], axis=-1)

    def near(self, points_m: Floats) -> Floats:
        """The points of a polyline near the image."""
        near: Floats = points_m[self.is_near(points_m)]
        return near

    def is_near(self, points_m: Floats) -> Bools:
        """(M,) whether points are near the image."""
        near: Bools = np.hypot(*(points_m - self.position_m).T) < 1.5 * (AHEAD_M + BEHIND_M)
        return near


def _road(canvas: Canvas, view: _View, scene: Scene) -> None:
    for left, right in scene.lines.strips_m:
        near = view.is_near(left) | view.is_near(right)
        if near.any():
            canvas.fill([view.place(np.concatenate([left[near], right[near][::-1]]))], ASPHALT, 1.0)
    for line in map(view.near, scene.lines.dashed_m):
        canvas.lines(_dashes(view.place(line)), MARKING, 1)
    canvas.lines([view.place(line) for line in map(view.near, scene.lines.solid_m) if len(line)], INK, 1)
    canvas.lines(_dashes(view.place(view.near(scene.route_m))), TARGET, 1)


def _dashes(line_px: Floats) -> list[Floats]:
    """Every third segment of a polyline."""
    return [line_px[start : start + 2] for start in range(0, len(line_px) - 1, 3)]


def _rectangle(canvas: Canvas, view: _View, obj: Rectangle, colour: Colour) -> None:
    corners = view.place(obj.corners_m)
    canvas.fill([corners], colour, 1.0)
    canvas.lines([corners], INK, 1, closed=True)


def _perceived(canvas: Canvas, view: _View, plan: Plan) -> None:
    """Draw the faces of perceived obstacles and the reference heading; the motion of a planner in space and time."""
    if isinstance(plan.extra, MotionPlan):
        canvas.lines([view.from_vehicle(plan.extra.points_m())], REFERENCE, 2)
    if plan.perception is None:
        return
    objects = plan.perception.obstacles
    for forward, left, right in zip(objects.forward_m, objects.left_m, objects.right_m, strict=True):
        face = np.array([(forward + 1.0, left), (forward, left), (forward, right), (forward + 1.0, right)])
        canvas.lines([view.from_vehicle(face)], OBSTACLE, 3)
    heading = plan.reference.heading_rad - float(plan.perception.pose[2])
    ray = np.outer([3.0, 12.0], [np.cos(heading), np.sin(heading)])
    canvas.lines([view.from_vehicle(ray)], REFERENCE, 2)


def _goal(canvas: Canvas, view: _View, goal_m: tuple[float, float]) -> None:
    """Draw the goal as a disc, on the image's border if it is outside."""
    place = view.place(np.array(goal_m))
    inside = np.clip(place, 10.0, view.size_px - 10.0)
    canvas.disc(inside, 5.0, TARGET)
    if not np.array_equal(place, inside):
        distance_m = float(np.hypot(*(np.array(goal_m) - view.position_m)))
        words = f"goal {distance_m:.0f} m"
        width = canvas.text_width_px(words, 0.5)
        left = float(inside[0]) + (10.0 if inside[0] < 0.5 * view.size_px[0] else -10.0 - width)
        canvas.text(words, left, float(inside[1]) + 5.0, TARGET, 0.5)


def _legend(canvas: Canvas, has_plan: bool) -> None:
    words = [("route", TARGET), ("objects", OBJECT)]
    if has_plan:
        words += [("perceived", OBSTACLE), ("reference heading", REFERENCE)]
    left = 12.0
    for word, colour in words:
        canvas.text(word, left, canvas.frame.shape[0] - 12.0, colour, 0.5)
        left += canvas.text_width_px(word, 0.5) + 12.0
