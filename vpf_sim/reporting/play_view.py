"""What a person who drives can have in the window: a driver's overlay, another driver's car as a ghost, the speed."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim import drivers
from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers.keyboard import View
from vpf_sim.envs.ego import Ego
from vpf_sim.errors import InputError, option
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.geometry import wrap_angle
from vpf_sim.reporting import overlay
from vpf_sim.reporting.canvas import Canvas, Colour
from vpf_sim.reporting.top_view import Rectangle
from vpf_sim.types import Floats, Image

GHOST: Colour = (186, 150, 255)
OVERLAY_KEY, GHOST_KEY = "o", "g"
KMPH_PER_MPS = 3.6


@dataclass(frozen=True, slots=True)
class Ghost:
    """The car of another driver on the same road, with the same seed."""

    driver: str
    steps: StepTable

    def from_ego(self, observation: Observation) -> Rectangle | None:
        """Its outline in the ego's axes at the time of an observation; None after its drive."""
        row = int(np.searchsorted(self.steps.time_s, observation.time_s - 1e-6))
        if row >= len(self.steps.time_s):
            return None
        cosine, sine = np.cos(observation.yaw_rad), np.sin(observation.yaw_rad)
        x_m, y_m = self.steps.positions_m[row] - observation.pose[:2]
        heading_rad = float(wrap_angle(self.steps.yaw_rad[row] - observation.yaw_rad))
        ahead_m, right_m = cosine * x_m + sine * y_m, -sine * x_m + cosine * y_m
        return Rectangle(float(ahead_m), float(right_m), heading_rad, Ego.LENGTH, Ego.WIDTH, "car")


class PlayView(View):
    """The camera's frame with speed and time; a key each adds the driver's overlay and the ghost."""

    def __init__(self, overlay_of: str, ghost: Ghost | None = None) -> None:
        self._seen_by = drivers.create(overlay_of)
        if self._seen_by.privileged != "none":
            raise InputError(f"{option('overlay')}: expected a driver that sees by camera, got '{overlay_of}'")
        self._ghost = ghost
        self._is_on: dict[str, bool] = {OVERLAY_KEY: False, GHOST_KEY: ghost is not None}
        self._last: Image | None = None

    @property
    def needs_every_frame(self) -> bool:
        """The driver of the overlay tracks from frame to frame."""
        return self._is_on[OVERLAY_KEY]

    def reset(self, setup: DriverSetup) -> None:
        self._setup = setup

    def press(self, key: str) -> None:
        if key not in self._is_on:
            return
        self._is_on[key] = not self._is_on[key]
        if key == OVERLAY_KEY and self._is_on[key]:
            self._seen_by.reset(self._setup)

    def picture(self, observation: Observation) -> Image:
        frame = observation.image
        if self._is_on[OVERLAY_KEY]:
            drivers.command_of(self._seen_by, observation)
            frame = overlay.draw(frame, drivers.trace_of(self._seen_by), self._setup.camera)
        canvas = Canvas(frame.copy(), self._setup.camera)
        words = [f"{KMPH_PER_MPS * observation.speed_mps:.0f} km/h", f"{observation.time_s:.1f} s"]
        if self._ghost is not None and self._is_on[GHOST_KEY]:
            words.append(self._draw_ghost(canvas, self._ghost, observation))
        write(canvas, words)
        self._last = canvas.frame
        return canvas.frame

    def last(self, words: Sequence[str]) -> Image:
        """The last picture, darker, with words on it."""
        assert self._last is not None
        canvas = Canvas((0.4 * self._last).astype(np.uint8), self._setup.camera)
        write(canvas, words)
        return canvas.frame

    def _draw_ghost(self, canvas: Canvas, ghost: Ghost, observation: Observation) -> str:
        """Draw the ghost if it is ahead, and return where it is."""
        outline = ghost.from_ego(observation)
        if outline is None:
            return f"{ghost.driver} is done"
        draw_box(canvas, outline)
        return f"{ghost.driver} {abs(outline.x_m):.0f} m {'ahead' if outline.x_m > 0.0 else 'behind'}"


def draw_box(canvas: Canvas, outline: Rectangle) -> None:
    """Draw a translucent box of a car's height over an outline in vehicle axes, if all of it is ahead of the camera."""
    levels: list[Floats] = [
        canvas.project(np.column_stack([outline.corners_m, np.full(4, height_m)])) for height_m in (0.0, Ego.HEIGHT)
    ]
    corners = np.concatenate(levels)
    if not np.isfinite(corners).all():
        return
    canvas.fill([cv2.convexHull(corners.astype(np.float32)).reshape(-1, 2).astype(float)], GHOST, 0.35)
    canvas.lines(levels, GHOST, 1, closed=True)
    canvas.lines([np.stack(edge) for edge in zip(*levels, strict=True)], GHOST, 1)


def write(canvas: Canvas, lines: Sequence[str]) -> None:
    """Write lines into the upper right corner, where an overlay has none."""
    width = canvas.frame.shape[1]
    for number, line in enumerate(lines):
        left = width - 12.0 * canvas.unit - canvas.text_width_px(line, 0.5)
        canvas.text(line, left, (24.0 + 22.0 * number) * canvas.unit, size=0.5)
