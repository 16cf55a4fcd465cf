"""An episode as video frames: camera with overlay, top view, and signals below."""

from collections.abc import Callable, Iterator

import numpy as np

from vpf_sim.reporting import overlay, top_view
from vpf_sim.reporting.canvas import INK, Canvas
from vpf_sim.reporting.redraw import Moment, Redrawing
from vpf_sim.reporting.signals import PAPER, SOFT, Strips, write
from vpf_sim.types import Camera, Image

TITLE_PX = 28
SIDE = 0.5  # width of the view from above, of the camera's
SIGNALS_PX = 212


def size_px(camera: Camera) -> tuple[int, int]:
    """(width, height) of the video."""
    return camera.width_px + round(SIDE * camera.width_px), TITLE_PX + camera.height_px + SIGNALS_PX


def frames(drawn: Redrawing, wanted: Callable[[int], bool] = lambda _: True) -> Iterator[tuple[int, Image]]:
    """Yield (row, (H, W, 3) RGB) of the wanted steps; the others are computed and not drawn."""
    strips = Strips(drawn.table, size_px(drawn.camera)[0], SIGNALS_PX)
    for moment in drawn.moments():
        if wanted(moment.index):
            yield moment.index, _compose(drawn, moment, strips)


def ending(drawn: Redrawing) -> str:
    """How the episode ended, as text."""
    return f"{drawn.record.ending} after {drawn.table.time_s[-1]:.1f} s"


def _compose(drawn: Redrawing, moment: Moment, strips: Strips) -> Image:
    camera, table = drawn.camera, drawn.table
    picture = moment.image if moment.plan is None else overlay.draw(moment.image, moment.plan, camera)
    row = moment.index
    pose = np.array([table.x_m[row], table.y_m[row], table.yaw_rad[row]])
    trail = table.positions_m[: row + 1]
    width, height = size_px(camera)
    side = width - camera.width_px
    above = top_view.draw(drawn.scene, moment.objects, trail, pose, moment.plan, side, camera.height_px)
    frame = np.empty((height, width, 3), np.uint8)
    frame[:TITLE_PX] = PAPER
    frame[TITLE_PX : TITLE_PX + camera.height_px, : camera.width_px] = picture
    frame[TITLE_PX : TITLE_PX + camera.height_px, camera.width_px :] = above
    frame[TITLE_PX + camera.height_px :] = strips.at(row)
    _title(Canvas(frame, Camera(width, height)), drawn, row)
    return frame


def _title(canvas: Canvas, drawn: Redrawing, row: int) -> None:
    """Draw the episode's id, ending, time and distance."""
    camera = drawn.camera
    write(canvas, drawn.record.id, 12, 19, INK, 0.48)
    write(canvas, ending(drawn), round(0.55 * camera.width_px), 19, SOFT, 0.44)
    clock = f"{drawn.table.time_s[row]:5.2f} s   {drawn.table.route_m[row]:.0f} m"
    write(canvas, clock, camera.width_px + 12, 19, INK, 0.48)
