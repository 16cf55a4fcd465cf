"""The video of a replayed drive: the driver's view, and its commands beside the recorded ones."""

from collections import deque
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from vpf_sim.replay.frame_table import FrameRow
from vpf_sim.replay.open_loop_driver import Decision
from vpf_sim.reporting import overlay
from vpf_sim.reporting.canvas import Canvas
from vpf_sim.reporting.episode_view import LINE, PAPER, PID, RULE, SOFT, write
from vpf_sim.reporting.video import Writer
from vpf_sim.types import Camera, Floats, Image

STRIP_PX = 84  # height of the plots of commands
SHOWN_S = 10.0
FIELD = (32, 37, 44)
LEAST = 0.25  # half range of the plots


class DriveVideo:
    """Writes frames to an .mp4 that browsers play."""

    def __init__(self, path: Path, camera: Camera, rate_hz: float, human: dict[str, str]) -> None:
        """`human` has the labels of the recorded throttle and steering."""
        self._camera = camera
        self._human = human
        self._size = (camera.width_px - camera.width_px % 2, camera.height_px + STRIP_PX)
        self._past: deque[FrameRow] = deque(maxlen=max(2, round(SHOWN_S * rate_hz)))
        self._blank: Image = np.full((camera.height_px, camera.width_px, 3), PAPER, np.uint8)
        self._writer = Writer(path, self._size, rate_hz)

    def write(self, image: Image | None, decision: Decision, row: FrameRow) -> None:
        """Add a frame with its overlay; a gap is an empty image with a text."""
        self._past.append(row)
        if image is None:
            shown = self._blank.copy()
            self._write_text(shown, "no frame: last prediction held")
        elif decision.plan is None:
            shown = image.copy()
        else:
            shown = overlay.draw(image, decision.plan, self._camera)
            if decision.is_held:
                self._write_text(shown, "flow unreliable: last prediction held")
            elif decision.road_found is False:
                self._write_text(shown, "no lane found: course and speed held, not scored")
        self._writer.write(np.vstack([shown, self._strip(shown.shape[1])]))

    def _write_text(self, shown: Image, words: str) -> None:
        canvas = Canvas(shown, self._camera)
        canvas.text(words, 12 * canvas.unit, 64 * canvas.unit, size=0.42)

    def _strip(self, width_px: int) -> Image:
        """(STRIP_PX, width, 3) recent throttle and steering, predicted and recorded."""
        canvas = Canvas(np.full((STRIP_PX, width_px, 3), PAPER, np.uint8), Camera(width_px, STRIP_PX))
        half = width_px // 2
        for left, name in ((8, "throttle"), (half + 8, "steering")):
            predicted = np.array([getattr(row, name) for row in self._past])
            recorded = np.array([getattr(row, f"recorded_{name}") for row in self._past])
            self._curves(canvas, (left, left + half - 16), predicted, recorded)
            write(canvas, name, left, 15, SOFT, 0.4)
            write(canvas, _reading(predicted[-1]), left + 74, 15, LINE, 0.4)
            write(canvas, f"{self._human[name]} {_reading(recorded[-1])}", left + 134, 15, PID, 0.4)
        return canvas.frame

    def _curves(self, canvas: Canvas, reach: tuple[int, int], predicted: Floats, recorded: Floats) -> None:
        left, right = reach
        top, bottom = 22, STRIP_PX - 6
        canvas.fill([np.array([(left, top), (right, top), (right, bottom), (left, bottom)], float)], FIELD, 1.0)
        middle = 0.5 * (top + bottom)
        canvas.lines([np.array([(left, middle), (right, middle)], float)], RULE, 1)
        both = np.concatenate([predicted, recorded])
        most = max(LEAST, float(np.max(np.abs(both[np.isfinite(both)]), initial=0.0)))
        x = right - (right - left) * np.arange(len(predicted))[::-1] / ((self._past.maxlen or 2) - 1)
        for values, colour in ((recorded, PID), (predicted, LINE)):
            there = np.isfinite(values)
            y = middle - 0.5 * (bottom - top) * values / most
            canvas.lines([np.stack([x, y], axis=1)[there]], colour, 1.5)
        write(canvas, f"+-{most:.2f}", left + 3, top + 11, SOFT, 0.32)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._writer.__exit__(kind, error, traceback)


def _reading(value: float) -> str:
    return f"{round(float(value), 2) + 0.0:+.2f}" if np.isfinite(value) else "--"
