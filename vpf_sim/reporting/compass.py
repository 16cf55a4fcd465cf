"""A compass of the planner's forces and reference heading; up is ahead."""

from math import cos, sin

import numpy as np

from vpf_sim.geometry import wrap_angle
from vpf_sim.reporting.canvas import SHADE, Canvas, Colour
from vpf_sim.types import Floats, Plan

TARGET: Colour = (98, 214, 124)
OBSTACLE: Colour = (255, 92, 72)
ROAD: Colour = (92, 176, 255)
TOTAL: Colour = (255, 255, 255)
REFERENCE: Colour = (255, 208, 64)
RADIUS = 44.0  # px on a frame of 640


def draw_compass(canvas: Canvas, plan: Plan) -> None:
    """Draw the compass in the lower right corner, with a legend below."""
    radius = RADIUS * canvas.unit
    height, width = canvas.frame.shape[:2]
    centre = np.array([width - radius - 14 * canvas.unit, height - radius - 24 * canvas.unit])
    canvas.disc(centre, radius + 3 * canvas.unit, SHADE, 0.62)
    canvas.ring(centre, radius, (150, 160, 170), 1)
    for angle in np.arange(0.0, 2.0 * np.pi, np.pi / 2.0):
        canvas.lines([_ray(centre, angle, 0.9 * radius, radius)], (150, 160, 170), 1)
    force = plan.force
    arrows = ((force.target, TARGET), (force.road, ROAD), (force.obstacle, OBSTACLE), (force.total, TOTAL))
    longest = max(float(np.hypot(*vector)) for vector, _ in arrows)
    for vector, colour in arrows:
        length = float(np.hypot(*vector))
        if np.isfinite(length) and longest > 0.0 and length > 1e-3 * longest:
            # The square root keeps small forces visible beside large ones.
            _arrow(canvas, centre, np.arctan2(vector[1], vector[0]), 0.82 * radius * np.sqrt(length / longest), colour)
    _pointer(canvas, centre, wrap_angle(plan.reference.heading_rad - float(plan.perception.pose[2])), radius)
    _legend(canvas, centre, radius)


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
    """Draw the reference heading as a wedge on the rim."""
    tip = _ray(centre, angle, 0.84 * radius, 0.84 * radius)[0]
    base = [_ray(centre, angle + side, 1.1 * radius, 1.1 * radius)[0] for side in (-0.13, 0.13)]
    wedge = np.stack([tip, *base])
    canvas.fill([wedge], REFERENCE, 1.0)
    canvas.lines([wedge], SHADE, 1, closed=True)


def _legend(canvas: Canvas, centre: Floats, radius: float) -> None:
    words = (("goal", TARGET), ("road", ROAD), ("obstacle", OBSTACLE))
    size = 0.32
    widths = [canvas.text_width_px(word, size) for word, _ in words]
    gap = 6 * canvas.unit
    left = float(centre[0]) - 0.5 * (sum(widths) + gap * (len(words) - 1))
    for (word, colour), width in zip(words, widths, strict=True):
        canvas.text(word, left, float(centre[1]) + radius + 15 * canvas.unit, colour, size)
        left += width + gap
