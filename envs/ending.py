"""When and how an episode ends: one status per step, "running" until the end."""

from dataclasses import dataclass
from math import hypot
from typing import Literal

import numpy as np

from vpf_sim.envs.contacts import free_ahead
from vpf_sim.envs.ego import Ego
from vpf_sim.envs.route import Route
from vpf_sim.scenarios import DrawnScenario
from vpf_sim.timing import timed
from vpf_sim.types import Image

Fault = Literal["black", "constant", "wrong shape", "stale"]
SAMPLE = 40  # px between the pixels of the cheap comparison that comes first


@dataclass(frozen=True, slots=True)
class InvalidFrame:
    """An invalid frame: its number (0 at the reset), its time and its fault."""

    frame: int
    time_s: float
    fault: Fault


def frame_fault(frame: Image, shape: tuple[int, ...], last: Image | None = None) -> Fault | None:
    """The fault of a frame that should have `shape` and differ from `last`; None for a valid frame."""
    if frame.shape != shape or frame.dtype != np.uint8:
        return "wrong shape"
    if _constant(frame):
        return "constant" if frame.any() else "black"
    return "stale" if last is not None and _same(frame, last) else None


def _constant(frame: Image) -> bool:
    """Whether all pixels have one colour."""
    first = frame[0, 0]
    return bool((frame[::SAMPLE, ::SAMPLE] == first).all() and (frame == first).all())


def _same(a: Image, b: Image) -> bool:
    if a.shape != b.shape:
        return False
    return bool((a[::SAMPLE, ::SAMPLE] == b[::SAMPLE, ::SAMPLE]).all() and (a == b).all())


Status = Literal["running", "success", "collision", "off_road", "timeout", "stuck", "invalid_frame"]
TERMINATED = frozenset({"success", "collision", "off_road"})
TRUNCATED = frozenset({"timeout", "stuck", "invalid_frame"})

STANDING_MPS, STANDING_S = 0.05, 2.0
STOP_AHEAD_M = (1.0, 15.0)
STUCK_MPS, STUCK_S = 0.2, 10.0
FRAME_MOVED_M = 0.02


class Ending:
    """Computes the status of every step of one episode.

    `invalid_frame` is the first invalid frame. Frames are None where none are rendered.
    """

    def __init__(
        self,
        scenario: DrawnScenario,
        route: Route,
        rate_hz: float,
        ego: Ego,
        frame: Image | None,
        shape: tuple[int, ...],
    ) -> None:
        """`frame` is the one at the reset, `shape` the shape that every frame must have."""
        self._scenario = scenario
        self._route = route
        self._rate_hz = rate_hz
        self._shape = shape
        self._steps = 0
        self._standing_steps = 0
        self._slow_steps = 0
        self._last_frame = frame
        self._last_position = ego.position
        self.invalid_frame: InvalidFrame | None = None
        self._check(frame)

    @property
    def status_at_reset(self) -> Status:
        return "running" if self.invalid_frame is None else "invalid_frame"

    @timed("ending")
    def status(self, ego: Ego, frame: Image | None) -> Status:
        """The status after one more step; call it once per step."""
        self._steps += 1
        self._slow_steps = self._slow_steps + 1 if ego.speed < STUCK_MPS else 0
        if frame is not None:
            self._check(frame, self._last_frame if self._moved(ego) else None)
            self._last_frame = frame
        if ego.crashed:
            return "collision"
        if ego.road.network.is_off_road(ego):
            return "off_road"
        if self._success(ego):
            return "success"
        if self.invalid_frame is not None:
            return "invalid_frame"
        if self._slow_steps >= STUCK_S * self._rate_hz:
            return "stuck"
        return "timeout" if self._steps >= self._scenario.time_limit_s * self._rate_hz else "running"

    def _success(self, ego: Ego) -> bool:
        if self._scenario.goal.kind == "reach":
            return self._route.is_at_goal(ego.place)
        stopped = ego.speed < STANDING_MPS and STOP_AHEAD_M[0] <= free_ahead(ego) <= STOP_AHEAD_M[1]
        self._standing_steps = self._standing_steps + 1 if stopped else 0
        return self._standing_steps >= STANDING_S * self._rate_hz

    def _moved(self, ego: Ego) -> bool:
        """Whether the ego has moved since the last frame."""
        (x, y), (last_x, last_y) = ego.position.tolist(), self._last_position.tolist()
        self._last_position = ego.position
        return hypot(x - last_x, y - last_y) > FRAME_MOVED_M

    def _check(self, frame: Image | None, last: Image | None = None) -> None:
        fault = None if frame is None else frame_fault(frame, self._shape, last)
        if fault is not None and self.invalid_frame is None:
            self.invalid_frame = InvalidFrame(self._steps, self._steps / self._rate_hz, fault)
