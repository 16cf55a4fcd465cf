"""An episode as video frames: camera with overlay, top view, and signals below."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting import overlay, top_view
from vpf_sim.reporting.canvas import FONT, INK, Canvas, Colour
from vpf_sim.reporting.redraw import Moment, Redrawing
from vpf_sim.types import Camera, Floats, Image

TITLE_PX = 28
SIDE = 0.5  # width of the view from above, of the camera's
SIGNALS_PX = 212
PAPER: Colour = (24, 28, 34)
RULE: Colour = (70, 78, 88)
SOFT: Colour = (150, 160, 170)
LINE: Colour = (92, 176, 255)
PID: Colour = (200, 160, 90)
DIM = 0.42  # brightness of the future part


@dataclass(frozen=True, slots=True)
class Signal:
    """A quantity over the steps."""

    name: str
    unit: str
    values: Floats  # (N,)
    beside: Floats | None  # (N,) the PID's commands in the same states
    low: float
    high: float


def signals_of(table: StepTable) -> tuple[Signal, ...]:
    """The four signals of an episode; commands have one value fewer than states."""
    widest = max(2.0, float(np.max(np.abs(table.lane_offset_m))))
    return (
        Signal("throttle", "", table.throttle, table.pid_throttle, -1.0, 1.0),
        Signal("steering", "", table.steering, table.pid_steering, -1.0, 1.0),
        Signal("speed", "m/s", table.speed_mps, None, 0.0, max(8.0, float(np.max(table.speed_mps)))),
        Signal("right of the lane's centre", "m", table.lane_offset_m, None, -widest, widest),
    )


class Strips:
    """The strip charts of an episode, drawn once; `at` adds the cursor."""

    def __init__(self, table: StepTable, width_px: int, height_px: int) -> None:
        self._signals = signals_of(table)
        self._count = len(table)
        self._boxes = _boxes(width_px, height_px)
        canvas = Canvas(np.full((height_px, width_px, 3), PAPER, np.uint8), Camera(width_px, height_px))
        for signal, box in zip(self._signals, self._boxes, strict=True):
            _draw_signal(canvas, signal, box)
        self._past = canvas.frame
        paper = np.array(PAPER, np.float32)
        self._future = (paper + DIM * (canvas.frame - paper)).astype(np.uint8)

    def at(self, index: int) -> Image:
        """(H, W, 3) charts with the past of a row in full colour, and the row's values."""
        frame = self._future.copy()
        canvas = Canvas(frame, Camera(frame.shape[1], frame.shape[0]))
        for signal, box in zip(self._signals, self._boxes, strict=True):
            cursor = box.left + round((box.right - box.left) * index / max(self._count, 1))
            frame[box.top : box.bottom + 1, box.left : cursor] = self._past[box.top : box.bottom + 1, box.left : cursor]
            canvas.lines([np.array([[cursor, box.top], [cursor, box.bottom]], float)], INK, 1)
            _words(canvas, signal, box, index)
        return frame


@dataclass(frozen=True, slots=True)
class _Box:
    """The position of a strip, px."""

    left: int
    top: int
    right: int
    bottom: int

    def chain(self, values: Floats, low: float, high: float) -> Floats:
        """(N, 2) px of the finite ones of N values."""
        x = np.linspace(self.left, self.right, len(values))
        y = self.bottom - (np.clip(values, low, high) - low) / (high - low) * (self.bottom - self.top)
        return np.stack([x, y], axis=1)[np.isfinite(values)]


def _boxes(width_px: int, height_px: int) -> list[_Box]:
    """The boxes of four strips, two by two."""
    half_width, half_height = width_px // 2, height_px // 2
    return [
        _Box(
            column * half_width + 12,
            row * half_height + 24,
            (column + 1) * half_width - 12,
            (row + 1) * half_height - 8,
        )
        for column in range(2)
        for row in range(2)
    ]


def _draw_signal(canvas: Canvas, signal: Signal, box: _Box) -> None:
    middle = box.chain(np.zeros(2), signal.low, signal.high)
    frame = np.array(
        [(box.left, box.top), (box.right, box.top), (box.right, box.bottom), (box.left, box.bottom)], float
    )
    canvas.fill([frame], (32, 37, 44), 1.0)
    canvas.lines([middle], RULE, 1)
    if signal.beside is not None:
        canvas.lines([box.chain(signal.beside, signal.low, signal.high)], PID, 1)
    canvas.lines([box.chain(signal.values, signal.low, signal.high)], LINE, 1.5)


def _words(canvas: Canvas, signal: Signal, box: _Box, index: int) -> None:
    value = signal.values[index]
    base = box.top - 7
    write(canvas, signal.name, box.left, base, SOFT)
    write(canvas, _reading(value, signal), box.left + 200, base, LINE)
    if signal.beside is not None:
        write(canvas, f"PID {_reading(signal.beside[index], signal)}", box.left + 290, base, PID)


def _reading(value: float, signal: Signal) -> str:
    """A formatted value with its unit; signed if the signal is, without negative zero."""
    if np.isnan(value):
        return "--"
    sign = "+" if signal.low < 0.0 else ""
    return f"{round(value, 2) + 0.0:{sign}.2f} {signal.unit}"


def write(canvas: Canvas, words: str, left: int, base: int, colour: Colour, size: float = 0.42) -> None:
    """Draw text without a background."""
    cv2.putText(canvas.frame, words, (left, base), FONT, size, colour, 1, cv2.LINE_AA)


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
    picture = overlay.draw(moment.image, moment.plan, camera)
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
