"""A window on the screen: it shows frames, and reads keys and a gamepad."""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from time import perf_counter, sleep
from typing import Any

from vpf_sim.errors import InputError
from vpf_sim.types import Image

DRIVER = "SDL_VIDEODRIVER"  # the environment variable
INVISIBLE_DRIVERS = frozenset({"dummy", "offscreen"})  # SDL drivers without a visible window
AXIS_LIMIT = 32767.0
# SDL's numbers of B, X, start and back, and the keys that they stand for.
BUTTONS = {1: "o", 2: "g", 6: "p", 4: "escape"}


class Window:
    """A window that shows frames; with `grows`, as large as fits on the screen."""

    def __init__(self, width_px: int, height_px: int, rate_hz: float, grows: bool = False) -> None:
        self._pygame = _pygame()
        with _quiet_driver():
            self._pygame.display.init()
        flags = self._pygame.SCALED | self._pygame.RESIZABLE if grows else 0
        with warnings.catch_warnings(action="ignore"):  # that SDL scales without a GPU
            self._surface = self._pygame.display.set_mode((width_px, height_px), flags)
        self.caption("vpf_sim")
        self._clock = self._pygame.time.Clock()
        self._rate_hz = rate_hz

    def caption(self, words: str) -> None:
        """Write words over the window."""
        self._pygame.display.set_caption(words)

    def show(self, frame: Image) -> None:
        """Draw an RGB frame (H, W, 3) and wait until it is due."""
        self._pygame.event.pump()
        self.draw(frame)
        self._clock.tick(self._rate_hz)

    def draw(self, frame: Image) -> None:
        """Draw an RGB frame (H, W, 3)."""
        self._pygame.surfarray.blit_array(self._surface, frame.swapaxes(0, 1))
        self._pygame.display.flip()

    def close(self) -> None:
        self._pygame.display.quit()


class Inputs:
    """Keys, by their names, and the axes of a gamepad; for as long as a window is there."""

    def __init__(self) -> None:
        self._pygame = _pygame()
        self._pads = _gamepads()
        self.held: set[str] = set()
        self.axes: dict[str, float] = {}  # "steering" in [-1, 1], "throttle" and "brake" in [0, 1]
        self._axes = {
            self._pygame.CONTROLLER_AXIS_LEFTX: "steering",
            self._pygame.CONTROLLER_AXIS_TRIGGERRIGHT: "throttle",
            self._pygame.CONTROLLER_AXIS_TRIGGERLEFT: "brake",
        }

    def poll(self) -> list[str]:
        """The keys that went down since the last call; KeyboardInterrupt after Escape or if the window was closed."""
        pressed = [key for event in self._pygame.event.get() if (key := self._take(event)) is not None]
        if "escape" in pressed:
            raise KeyboardInterrupt
        return pressed

    def wait(self) -> list[str]:
        """The keys that go down next."""
        while not (pressed := self.poll()):
            self._pygame.time.wait(10)
        return pressed

    def _take(self, event: Any) -> str | None:
        """The key that an event presses, if it does."""
        kinds = self._pygame
        if event.type == kinds.QUIT:
            return "escape"
        if event.type == kinds.CONTROLLERAXISMOTION and event.axis in self._axes:
            self.axes[self._axes[event.axis]] = max(event.value / AXIS_LIMIT, -1.0)
        elif event.type == kinds.CONTROLLERBUTTONDOWN:
            return BUTTONS.get(event.button, "button")
        elif event.type == kinds.KEYDOWN:
            name = str(kinds.key.name(event.key))
            self.held.add(name)
            return name
        elif event.type == kinds.KEYUP:
            self.held.discard(kinds.key.name(event.key))
        return None


@dataclass(slots=True)
class Pace:
    """Keeps the clock of a simulation beside the real one; a slow simulation falls behind and does not catch up."""

    rate_hz: float
    _zero_s: float = field(default=0.0, init=False)
    is_late: bool = field(default=False, init=False)  # by a frame or more

    def start(self, time_s: float) -> None:
        """It is this time now."""
        self._zero_s, self.is_late = perf_counter() - time_s, False

    def wait(self, time_s: float) -> None:
        """Sleep until this time."""
        behind_s = perf_counter() - self._zero_s - time_s
        if behind_s < 0.0:
            sleep(-behind_s)
        most_s = 6.0 / self.rate_hz
        self._zero_s += max(behind_s - most_s, 0.0)
        self.is_late = behind_s > 1.0 / self.rate_hz


def require_display() -> None:
    """InputError if no visible window is available; SDL itself falls back to an invisible one silently."""
    driver = os.environ.get(DRIVER) or _default_driver()
    if driver in INVISIBLE_DRIVERS:
        raise InputError(f"no display: expected one that a window can be seen on, got SDL's driver '{driver}'")


@contextmanager
def _quiet_driver() -> Iterator[None]:
    """Name the driver to SDL on a Linux without a display: its own search prints errors on stderr."""
    if _has_display() or os.environ.get(DRIVER):
        yield
        return
    os.environ[DRIVER] = "offscreen"
    try:
        yield
    finally:
        del os.environ[DRIVER]


def _has_display() -> bool:
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _default_driver() -> str:
    """SDL's choice; not queried on a Linux without a display, where SDL prints errors on stderr."""
    if not _has_display():
        return "offscreen"
    pygame = _pygame()
    pygame.display.init()
    driver = str(pygame.display.get_driver())
    pygame.display.quit()
    return driver


def _gamepads() -> list[Any]:
    """The gamepads, opened, so that their events arrive; none where SDL has no support for them."""
    with suppress(ImportError, _pygame().error):
        from pygame._sdl2 import controller

        controller.init()
        return [controller.Controller(i) for i in range(controller.get_count()) if controller.is_controller(i)]
    return []


def _pygame() -> Any:
    """pygame, imported without its banner on stdout."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    import pygame

    return pygame
