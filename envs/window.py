"""The live window of `render_mode="human"`."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vpf_sim.errors import InputError
from vpf_sim.types import Image

DRIVER = "SDL_VIDEODRIVER"  # the environment variable
INVISIBLE_DRIVERS = frozenset({"dummy", "offscreen"})  # SDL drivers without a visible window


class Window:
    """A window that shows frames in real time."""

    def __init__(self, width_px: int, height_px: int, rate_hz: float) -> None:
        self._pygame = _pygame()
        with _quiet_driver():
            self._pygame.display.init()
        self._surface = self._pygame.display.set_mode((width_px, height_px))
        self._pygame.display.set_caption("vpf_sim")
        self._clock = self._pygame.time.Clock()
        self._rate_hz = rate_hz

    def show(self, frame: Image) -> None:
        """Draw an RGB frame (H, W, 3) and wait until it is due."""
        self._pygame.event.pump()
        self._pygame.surfarray.blit_array(self._surface, frame.swapaxes(0, 1))
        self._pygame.display.flip()
        self._clock.tick(self._rate_hz)

    def close(self) -> None:
        self._pygame.display.quit()


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


def _pygame() -> Any:
    """pygame, imported without its banner on stdout."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    import pygame

    return pygame
