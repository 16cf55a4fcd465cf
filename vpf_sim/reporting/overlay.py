"""Draws a driver's perception and plan into its frame."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from vpf_sim.geometry import distort, wrap_angle
from vpf_sim.planning.paper.planner import PaperPlan
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.reporting.canvas import INK, SHADE, Canvas, Colour
from vpf_sim.reporting.plan_view import PATH, draw_motion
from vpf_sim.reporting.top_view import OBSTACLE, REFERENCE, draw_compass
from vpf_sim.types import Camera, Floats, Image, Perception, Plan, RoadEdges

EDGE: Colour = (92, 220, 255)
UNKNOWN: Colour = (205, 212, 220)
# Time to contact from short to long: red, yellow, green.
TTC_S = np.array([0.8, 1.8, 3.5, 8.0])
TTC_STEPS_S = np.array([0.8, 1.2, 1.8, 2.5, 3.5, 5.0, 8.0, 1e6])
TTC_RGB = np.array([(255, 40, 40), (255, 110, 40), (255, 220, 60), (70, 225, 120)], float)

ROAD_AHEAD_M = np.linspace(2.0, 45.0, 60)  # along the road
PATH_AHEAD_M = np.linspace(2.0, 24.0, 40)
PATH_WIDTH_M = 1.9
SHIFT_M = 16.0  # length of the drawn transition to the planned lateral position
OBSTACLE_HEIGHT_M = 1.4
OBSTACLE_LENGTH_M = 3.0
LABEL_GAP_PX = 8.0  # between labels side by side
LABEL_ROW_PX = 18.0  # between labels one above the other


class Label(NamedTuple):
    """Text over an obstacle."""

    words: str
    left_px: float
    right_px: float
    base_px: float

    def covers(self, other: "Label", unit: float) -> bool:
        """Whether one of the two would make the other unreadable; `unit` as in Canvas."""
        gap = LABEL_GAP_PX * unit
        beside = self.left_px > other.right_px + gap or other.left_px > self.right_px + gap
        return not beside and abs(self.base_px - other.base_px) < LABEL_ROW_PX * unit


def draw(frame_rgb: Image, plan: Plan | None, camera: Camera) -> Image:
    """A copy of an (H, W, 3) RGB frame of any camera, with the plan drawn in; without a plan the frame itself."""
    if plan is None:
        return frame_rgb
    canvas = Canvas(frame_rgb.copy(), camera)
    if isinstance(plan.extra, MotionPlan):
        draw_motion(canvas, plan.extra)
    if plan.perception is not None:
        _draw_perception(canvas, plan, plan.perception)
    canvas.text(f"reference {plan.reference.speed_mps:.1f} m/s", *_corner(canvas, 43), REFERENCE, 0.36)
    return canvas.frame


def _draw_perception(canvas: Canvas, plan: Plan, perception: Perception) -> None:
    _map_tint(canvas, perception)
    _road(canvas, plan, perception.road)
    _flow(canvas, perception)
    _draw_obstacles(canvas, perception)
    _expansion(canvas, perception)
    draw_compass(canvas, plan.force, wrap_angle(plan.reference.heading_rad - float(perception.pose[2])))
    _draw_speed(canvas, perception)


def road_line(road: RoadEdges, right_m: Floats | float, along_m: Floats) -> Floats:
    """(M, 2) m, vehicle axes: points at `along_m` on the road-parallel line `right_m` right of the pose."""
    k = road.curvature_per_m
    heading = road.heading_rad + k * along_m
    half = 0.5 * k * along_m
    chord = along_m * np.sinc(half / np.pi)  # 2 sin(k s / 2) / k
    middle = road.heading_rad + half
    x = chord * np.cos(middle) - right_m * np.sin(heading)
    y = chord * np.sin(middle) + right_m * np.cos(heading)
    return np.stack([x, y], axis=-1)


def _map_tint(canvas: Canvas, perception: Perception) -> None:
    """Tint the obstacle map's area slightly red."""
    plane = perception.features.obstacle_map.plane
    if not np.any(plane):
        return
    height, width = canvas.frame.shape[:2]
    mask = cv2.resize(np.clip(plane, 0.0, 1.0).astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR)
    rows = np.flatnonzero(mask.max(axis=1) > 0.01)
    part = canvas.frame[rows[0] : rows[-1] + 1]
    weight = 0.22 * mask[rows[0] : rows[-1] + 1, :, None]
    part[:] = (part + weight * (np.array(OBSTACLE, np.float32) - part)).astype(np.uint8)


def _road(canvas: Canvas, plan: Plan, road: RoadEdges) -> None:
    """Draw the carriageway's edges, and the paper planner's way to the preferred position."""
    edges = [road_line(road, offset, ROAD_AHEAD_M) for offset in (road.left_m, road.right_m)]
    strokes = [_in_front(canvas, edge) for edge in edges]
    canvas.lines(strokes, SHADE, 4)
    canvas.lines(strokes, EDGE if road.confidence > 0.0 else UNKNOWN, 2)
    if not isinstance(plan.extra, PaperPlan):
        return
    middle = -plan.extra.lane.y_m
    share = np.clip((PATH_AHEAD_M - PATH_AHEAD_M[0]) / SHIFT_M, 0.0, 1.0)
    place = middle * share**2 * (3.0 - 2.0 * share)
    sides = [road_line(road, place + side * 0.5 * PATH_WIDTH_M, PATH_AHEAD_M) for side in (-1.0, 1.0)]
    left, right = (canvas.project(side) for side in sides)
    near = np.all(np.isfinite(left) & np.isfinite(right), axis=1)
    canvas.fill([np.concatenate([left[near], right[near][::-1]])], PATH, 0.5, top_opacity=0.15)


def _in_front(canvas: Canvas, line_m: Floats) -> Floats:
    """(M, 2) px, the part of a line on the road in front of the camera."""
    pixels = canvas.project(line_m)
    return pixels[np.all(np.isfinite(pixels), axis=1)]


def ttc_colour(ttc_s: float) -> Colour:
    """The colour of a time to contact: red, yellow, green; grey if unknown."""
    if not np.isfinite(ttc_s):
        return UNKNOWN
    red, green, blue = (int(np.interp(ttc_s, TTC_S, TTC_RGB[:, i])) for i in range(3))
    return red, green, blue


def _flow(canvas: Canvas, perception: Perception) -> None:
    """Draw each point's flow, coloured by time to contact."""
    flow = perception.flow
    step = np.digitize(perception.features.ttc_s, TTC_STEPS_S)
    for i, colour in enumerate([*(ttc_colour(float(ttc)) for ttc in TTC_STEPS_S), UNKNOWN]):
        chosen = flow.points_px[step == i]
        past = distort(canvas.camera, chosen - flow.displacement_px[step == i])
        now = distort(canvas.camera, chosen)
        canvas.lines(list(np.stack([past, now], axis=1)), colour, 1)
        for point in now:
            cv2.circle(canvas.frame, _whole(point), canvas.stroke_px(1.6), colour, -1, cv2.LINE_AA)


def _draw_obstacles(canvas: Canvas, perception: Perception) -> None:
    """Draw each obstacle as a box on the road, with distance and time to contact."""
    obstacles = perception.obstacles
    labels: list[Label] = []  # from far to near
    for i in np.argsort(-obstacles.forward_m):
        near, left, right = float(obstacles.forward_m[i]), float(obstacles.left_m[i]), float(obstacles.right_m[i])
        corners = [(near, left), (near, right), (near + OBSTACLE_LENGTH_M, right), (near + OBSTACLE_LENGTH_M, left)]
        foot = canvas.project(np.array(corners))
        head = canvas.project(np.array([(x, y, OBSTACLE_HEIGHT_M) for x, y in corners]))
        if not (np.all(np.isfinite(foot)) and np.all(np.isfinite(head))):
            continue
        _box(canvas, foot, head)
        ttc = float(obstacles.ttc_s[i])
        words = f"{near:.1f} m" + (f"  {ttc:.1f} s" if np.isfinite(ttc) else "")
        centre, half = 0.5 * float(head[0, 0] + head[1, 0]), 0.5 * canvas.text_width_px(words)
        labels.append(Label(words, centre - half, centre + half, float(head[0, 1]) - 6 * canvas.unit))
    for label in uncovered(labels[::-1], canvas.unit):
        canvas.text(label.words, label.left_px, label.base_px)


def _box(canvas: Canvas, foot_px: Floats, head_px: Floats) -> None:
    """Draw a box from its (4, 2) px corners on the road and above; the first two are of the near face."""
    face = np.stack([foot_px[0], foot_px[1], head_px[1], head_px[0]])
    canvas.fill([foot_px], OBSTACLE, 0.30)
    canvas.fill([face], OBSTACLE, 0.16)
    canvas.lines([head_px, foot_px], OBSTACLE, 1, closed=True)
    canvas.lines([np.stack([foot_px[j], head_px[j]]) for j in range(4)], OBSTACLE, 1)
    canvas.lines([face], SHADE, 3, closed=True)
    canvas.lines([face], OBSTACLE, 2, closed=True)


def uncovered(labels: Sequence[Label], unit: float = 1.0) -> list[Label]:
    """The labels, from near to far, that no nearer one would cover."""
    kept: list[Label] = []
    for label in labels:
        if not any(label.covers(other, unit) for other in kept):
            kept.append(label)
    return kept


def _expansion(canvas: Canvas, perception: Perception) -> None:
    """Draw the focus of expansion, grey with confidence 0."""
    expansion = perception.expansion
    centre = np.array([expansion.x_px, expansion.y_px])
    if not np.all(np.isfinite(centre)):
        return
    colour = INK if expansion.confidence > 0.0 else UNKNOWN
    ring, reach = 7.0 * canvas.unit, 13.0 * canvas.unit
    axes = (np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    cross = [np.stack([centre + sign * ring * axis, centre + sign * reach * axis]) for axis in axes for sign in (-1, 1)]
    for stroke, width in ((SHADE, 4), (colour, 2)):
        canvas.ring(centre, ring, stroke, width)
        canvas.lines(cross, stroke, width)
    canvas.text("FOE", float(centre[0]) + reach + 3, float(centre[1]) - 5 * canvas.unit, colour, 0.34)


def _draw_speed(canvas: Canvas, perception: Perception) -> None:
    """Draw the speed in the upper left corner."""
    speed = _speed_mps(perception)
    now = "-- m/s" if speed is None else f"{speed:.1f} m/s"
    canvas.text(now, *_corner(canvas, 26), size=0.62)


def _corner(canvas: Canvas, row: float) -> tuple[float, float]:
    """px, where text of the upper left corner begins."""
    return 12 * canvas.unit, row * canvas.unit


def _speed_mps(perception: Perception) -> float | None:
    """Speed from the poses at both ends of the longest flow window; None without one."""
    flow = perception.flow
    if not len(flow) or flow.gap_s.max() <= 0.0:
        return None
    i = int(np.argmax(flow.gap_s))
    return float(np.hypot(*(flow.pose - flow.past_pose[i])[:2]) / flow.gap_s[i])


def _whole(point: Floats) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))
