"""View of a motion in the frame, with what was rejected."""

import numpy as np

from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.reporting.canvas import INK, Canvas, Colour
from vpf_sim.types import Floats

PATH: Colour = (120, 255, 150)
BROKEN: Colour = (255, 92, 72)  # of a motion that breaks a limit, as all others do
CAR_WIDTH_M = 1.9
FIRST_ROW, ROW = 62.0, 14.0  # of the words, below those of the speed


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
